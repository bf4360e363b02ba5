#include "drivers/linux/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>

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

/// The file behind a chain of symbolic links, or the path itself.
std::string BehindLinks(const std::string& path) {
  char real[PATH_MAX];
  return realpath(path.c_str(), real) != nullptr ? real : path;
}

std::string FolderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
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

Result<void> FillAndRename(const std::string& path, const std::string& target, std::string_view bytes,
                           Flush flush) {
  struct stat present {};
  const bool exists = stat(target.c_str(), &present) == 0;
  // A rename onto /dev/null or onto a folder would replace the node itself.
  if (exists && !S_ISREG(present.st_mode))
    return Error{ErrorCode::kUsage, path, "is not a regular file; give the path of a file to write"};
  std::string temporary;
  FileDescriptor file = CreateBeside(target, temporary);
  if (!file) return Failure(path, "creating a temporary file beside it");
  const auto give_up = [&path, &temporary](const char* step) {
    const Error failure = Failure(path, step);
    unlink(temporary.c_str());
    return failure;
  };
  if (!WriteAll(file.Get(), bytes)) return give_up("writing");
  if (exists && fchmod(file.Get(), present.st_mode & 07777) != 0) return give_up("keeping its permissions");
  // Before the rename: otherwise a power cut can leave the new name on an empty file.
  if (flush == Flush::kYes && fsync(file.Get()) != 0) return give_up("flushing");
  file.Close();
  if (rename(temporary.c_str(), target.c_str()) != 0) return give_up("renaming");
  return {};
}

}  // namespace

Result<void> WriteFileAtomically(const std::string& path, std::string_view bytes, Flush flush) {
  const std::string target = BehindLinks(path);
  if (auto done = FillAndRename(path, target, bytes, flush); !done) return done;
  if (flush == Flush::kNo) return {};
  // The rename itself is on the disk only when the folder is.
  const FileDescriptor folder(open(FolderOf(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || fsync(folder.Get()) != 0) return Failure(path, "flushing its folder");
  return {};
}

}  // namespace adit::linux
