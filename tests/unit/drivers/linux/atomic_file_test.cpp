#include "drivers/linux/atomic_file.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include <CppUTest/TestHarness.h>

using adit::linux::Flush;
using adit::linux::WriteFileAtomically;
using adit::linux::WriteFilesAtomically;
namespace fs = std::filesystem;

namespace {

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

long FilesIn(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

}  // namespace

TEST_GROUP(AtomicFile) {
  fs::path folder;
  void setup() override {
    std::string name = (fs::temp_directory_path() / "adit-atomic-XXXXXX").string();
    CHECK(mkdtemp(name.data()) != nullptr);
    folder = name;
  }
  void teardown() override {
    fs::remove_all(folder);
    folder.clear();
  }
};

TEST(AtomicFile, WritesEveryByteAndLeavesNothingElse) {
  std::string bytes("a\0b\n\xff", 5);
  bytes += std::string(300000, 'x');
  CHECK(!!WriteFileAtomically((folder / "new.yaml").string(), bytes));
  CHECK(Content(folder / "new.yaml") == bytes);
  CHECK_EQUAL(1, FilesIn(folder));
}

TEST(AtomicFile, ReplacesTheOldFileAndKeepsItsPermissions) {
  const fs::path path = folder / "old.yaml";
  CHECK(!!WriteFileAtomically(path.string(), "old and longer"));
  fs::permissions(path, fs::perms(0640));
  CHECK(!!WriteFileAtomically(path.string(), "new"));
  CHECK(Content(path) == "new");
  CHECK(fs::status(path).permissions() == fs::perms(0640));
  CHECK_EQUAL(1, FilesIn(folder));
}

TEST(AtomicFile, WithoutAFlushIsReplacedAsAWholeToo) {
  const fs::path path = folder / "report.yaml";
  CHECK(!!WriteFileAtomically(path.string(), "first and longer", Flush::kNo));
  CHECK(!!WriteFileAtomically(path.string(), "second", Flush::kNo));
  CHECK(Content(path) == "second");
  CHECK_EQUAL(1, FilesIn(folder));
  CHECK(!WriteFileAtomically((folder / "absent" / "report.yaml").string(), "x", Flush::kNo));
}

TEST(AtomicFile, GivesANewFileWhatTheUsersMaskLeaves) {
  const mode_t mask = umask(0027);
  const bool done = static_cast<bool>(WriteFileAtomically((folder / "f").string(), "x"));
  umask(mask);
  CHECK(done);
  CHECK(fs::status(folder / "f").permissions() == fs::perms(0640));
}

TEST(AtomicFile, ReplacesTheFileBehindASymbolicLink) {
  fs::create_directory(folder / "sub");
  CHECK(!!WriteFileAtomically((folder / "sub" / "real").string(), "old"));
  fs::create_symlink("sub/real", folder / "link");
  CHECK(!!WriteFileAtomically((folder / "link").string(), "new"));
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(Content(folder / "sub" / "real") == "new");
}

TEST(AtomicFile, RefusesAMissingFolderByNamingThePath) {
  const std::string path = (folder / "missing" / "f").string();
  const auto done = WriteFileAtomically(path, "x");
  CHECK_FALSE(done);
  STRCMP_EQUAL(
      (path + ": cannot be written: creating a temporary file beside it: No such file or directory").c_str(),
      done.error().Line().c_str());
  CHECK_EQUAL(1, done.error().ExitCode());
}

TEST(AtomicFile, RefusesAFolderAndLeavesIt) {
  const auto done = WriteFileAtomically(folder.string(), "x");
  CHECK_FALSE(done);
  STRCMP_EQUAL((folder.string() + ": is not a regular file; give the path of a file to write").c_str(),
               done.error().Line().c_str());
  CHECK(fs::is_directory(folder));
  CHECK_EQUAL(2, done.error().ExitCode());
}

TEST(AtomicFile, RefusesADeviceInsteadOfReplacingItsNode) {
  const fs::path pipe = folder / "pipe";
  LONGS_EQUAL(0, mkfifo(pipe.c_str(), 0600));
  CHECK_FALSE(WriteFileAtomically(pipe.string(), "x"));
  CHECK(fs::is_fifo(pipe));
}

TEST(AtomicFile, KeepsTheOldFileAndCleansUpWhenTheDiskFillsHalfWay) {
  const std::string path = (folder / "f").string();
  CHECK(!!WriteFileAtomically(path, "old"));
  // A limit on the size of files fails a write half way, as a full disk does.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1000, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const auto done = WriteFileAtomically(path, std::string(5000, 'n'));
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  CHECK_FALSE(done);
  STRCMP_EQUAL((path + ": cannot be written: writing: File too large").c_str(), done.error().Line().c_str());
  CHECK(Content(path) == "old");
  CHECK_EQUAL(1, FilesIn(folder));
}

TEST(AtomicFile, WritesAllOfSeveralFiles) {
  CHECK(!!WriteFilesAtomically({{(folder / "a").string(), "first"}, {(folder / "b").string(), "second"}}));
  CHECK(Content(folder / "a") == "first");
  CHECK(Content(folder / "b") == "second");
  CHECK_EQUAL(2, FilesIn(folder));
}

TEST(AtomicFile, WritesNoneOfSeveralFilesIfOneCannotBe) {
  CHECK(!!WriteFileAtomically((folder / "old").string(), "old"));
  const std::string missing = (folder / "missing" / "page").string();
  const auto done = WriteFilesAtomically(
      {{(folder / "old").string(), "new"}, {(folder / "first").string(), "x"}, {missing, "y"}});
  CHECK_FALSE(done);
  STRCMP_CONTAINS((missing + ": cannot be written").c_str(), done.error().Line().c_str());
  CHECK(Content(folder / "old") == "old");
  CHECK_EQUAL(1, FilesIn(folder));
}

TEST(AtomicFile, RefusesTwoTextsForOneFile) {
  CHECK(!!WriteFileAtomically((folder / "old").string(), "old"));
  fs::create_symlink("old", folder / "link");
  fs::create_directory(folder / "sub");
  const auto refused = [this](const char* a, const char* b) {
    const auto done = WriteFilesAtomically({{(folder / a).string(), "1"}, {(folder / b).string(), "2"}});
    CHECK_FALSE(done);
    STRCMP_EQUAL(((folder / b).string() + ": is named for two outputs; give each a file of its own").c_str(),
                 done.error().Line().c_str());
    CHECK_EQUAL(2, done.error().ExitCode());
  };
  refused("new", "new");
  refused("new", "sub/../new");
  refused("old", "link");
  CHECK(Content(folder / "old") == "old");
  CHECK_FALSE(fs::exists(folder / "new"));
}

TEST(AtomicFile, StepsOverATemporaryFileThatAKilledProcessLeft) {
  const std::string path = (folder / "f").string();
  std::ofstream(path + ".new-" + std::to_string(gettid()) + "-0") << "half";
  CHECK(!!WriteFileAtomically(path, "whole"));
  CHECK(Content(path) == "whole");
}

TEST(AtomicFile, ShowsReadersOnlyWholeFilesWhileTwoThreadsWrite) {
  const std::string path = (folder / "f").string();
  const std::string a(50000, 'a'), b(70000, 'b');
  CHECK(!!WriteFileAtomically(path, a));
  const auto write = [&path](const std::string& text) {
    for (int i = 0; i < 20; ++i) {
      if (!WriteFileAtomically(path, text)) std::abort();
    }
  };
  std::thread first(write, a), second(write, b);
  int torn = 0;
  for (int i = 0; i < 200; ++i) {
    const std::string seen = Content(path);
    if (seen != a && seen != b) ++torn;
  }
  first.join();
  second.join();
  LONGS_EQUAL(0, torn);
  CHECK_EQUAL(1, FilesIn(folder));
}
