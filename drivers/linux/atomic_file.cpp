#include "drivers/linux/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "drivers/linux/file_descriptor.h"

namespace adit::linux {
namespace {

using base::Error;
using base::ErrorCode;
using base::Result;

Error Failure(const std::string& path, const char* step) {
  const int reason = errno;
  const ErrorCode code = reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kFailed;
  return {code, path, std::string("cannot be written: ") + step + ": " + std::strerror(reason)};
}

std::string FolderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

/// The file that a path means: behind symbolic links, or, if there is none yet, its place in its folder.
std::string Meant(const std::string& path) {
  char real[PATH_MAX];
  if (realpath(path.c_str(), real) != nullptr) return real;
  if (realpath(FolderOf(path).c_str(), real) == nullptr) return path;
  return std::string(real) + "/" + path.substr(path.rfind('/') + 1);
}

bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Creates a file beside `target` under a name that nobody uses. Its permissions are what the user's mask
/// leaves of 0666.
FileDescriptor CreateBeside(const std::string& target, std::string& temporary) {
  constexpr int kMostAttempts = 100;  // each meets a file that a killed process left behind
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    // A thread id is unique among all that run.
    temporary = target + ".new-" + std::to_string(gettid()) + "-" + std::to_string(attempt);
    FileDescriptor file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file || errno != EEXIST) return file;
  }
  return {};
}

/// A text that is whole under a temporary name, which goes if the text does not take its own.
class Draft {
 public:
  static Result<Draft> Fill(const std::string& path, std::string_view bytes, Flush flush) {
    Draft draft(path);
    struct stat present {};
    const bool exists = stat(draft.target_.c_str(), &present) == 0;
    // A rename onto /dev/null or onto a folder would replace the node itself.
    if (exists && !S_ISREG(present.st_mode))
      return Error{ErrorCode::kUsage, path, "is not a regular file; give the path of a file to write"};
    std::string temporary;
    FileDescriptor file = CreateBeside(draft.target_, temporary);
    if (!file) return Failure(path, "creating a temporary file beside it");
    draft.temporary_ = temporary;
    if (!WriteAll(file.Get(), bytes)) return Failure(path, "writing");
    if (exists && fchmod(file.Get(), present.st_mode & 07777) != 0)
      return Failure(path, "keeping its permissions");
    // Before the rename: otherwise a power cut can leave the new name on an empty file.
    if (flush == Flush::kYes && fsync(file.Get()) != 0) return Failure(path, "flushing");
    return draft;
  }

  Draft(Draft&& other) noexcept
      : path_(std::move(other.path_)),
        target_(std::move(other.target_)),
        temporary_(std::exchange(other.temporary_, {})) {}
  Draft& operator=(Draft&&) = delete;
  ~Draft() {
    if (!temporary_.empty()) unlink(temporary_.c_str());
  }

  Result<void> TakeName() {
    if (rename(temporary_.c_str(), target_.c_str()) != 0) return Failure(path_, "renaming");
    temporary_.clear();
    return {};
  }
  /// The rename itself is on the disk only when the folder is.
  Result<void> FlushFolder() const {
    const FileDescriptor folder(open(FolderOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder || fsync(folder.Get()) != 0) return Failure(path_, "flushing its folder");
    return {};
  }
  bool IsFor(const std::string& target) const { return target_ == target; }

 private:
  explicit Draft(const std::string& path) : path_(path), target_(Meant(path)) {}

  std::string path_, target_, temporary_;
};

Result<void> Publish(std::vector<Draft>& drafts, Flush flush) {
  for (Draft& draft : drafts) {
    if (auto done = draft.TakeName(); !done) return done;
  }
  if (flush == Flush::kNo) return {};
  for (const Draft& draft : drafts) {
    if (auto done = draft.FlushFolder(); !done) return done;
  }
  return {};
}

}  // namespace

Result<void> WriteFileAtomically(const std::string& path, std::string_view bytes, Flush flush) {
  auto draft = Draft::Fill(path, bytes, flush);
  if (!draft) return draft.error();
  std::vector<Draft> drafts;
  drafts.push_back(std::move(*draft));
  return Publish(drafts, flush);
}

Result<void> WriteFilesAtomically(const std::vector<FileText>& files, Flush flush) {
  std::vector<Draft> drafts;
  for (const FileText& file : files) {
    const std::string target = Meant(file.path);
    for (const Draft& draft : drafts) {
      if (draft.IsFor(target))
        return Error{ErrorCode::kUsage, file.path, "is named for two outputs; give each a file of its own"};
    }
    auto draft = Draft::Fill(file.path, file.text, flush);
    if (!draft) return draft.error();
    drafts.push_back(std::move(*draft));
  }
  return Publish(drafts, flush);
}

}  // namespace adit::linux
