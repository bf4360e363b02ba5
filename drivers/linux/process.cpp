#include "drivers/linux/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/linux/system_clock.h"
#include "firmware/base/require.h"

namespace adit::linux {
namespace {

using base::Error;
using base::ErrorCode;

/// posix_spawn's two settings objects, freed whatever happens.
struct SpawnPlan {
  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};

  SpawnPlan() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    // A parent that waits for its signals blocks them; a child that inherits that cannot be terminated.
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
  ~SpawnPlan() {
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
  }
};

base::DurationNs Ns(const timeval& time) {
  return time.tv_sec * base::kNsPerS + time.tv_usec * base::kNsPerUs;
}

timespec Timespec(std::int64_t ns) {
  timespec time{};
  if (ns > 0) {
    time.tv_sec = ns / base::kNsPerS;
    time.tv_nsec = ns % base::kNsPerS;
  }
  return time;
}

}  // namespace

base::Result<Process> Process::Spawn(const std::vector<std::string>& arguments, ProcessOutput output) {
  ADIT_REQUIRE(!arguments.empty());
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  SpawnPlan plan;
  FileDescriptor read_end, write_end;
  if (output.capture_stdout) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return Error{ErrorCode::kFailed, arguments[0], std::strerror(errno)};
    read_end = FileDescriptor(ends[0]);
    write_end = FileDescriptor(ends[1]);
    posix_spawn_file_actions_adddup2(&plan.actions, write_end.Get(), STDOUT_FILENO);
  }
  if (!output.stderr_path.empty()) {
    posix_spawn_file_actions_addopen(&plan.actions, STDERR_FILENO, output.stderr_path.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0644);
  }
  pid_t id = -1;
  const int error = posix_spawnp(&id, argv[0], &plan.actions, &plan.attributes, argv.data(), environ);
  if (error != 0) {
    return Error{error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kFailed, arguments[0],
                 std::string("cannot be started: ") + std::strerror(error)};
  }
  return Process(id, std::move(read_end));
}

Process::Process(Process&& other) noexcept
    : id_(std::exchange(other.id_, -1)),
      output_(std::move(other.output_)),
      buffer_(std::move(other.buffer_)),
      end_(other.end_) {}

Process& Process::operator=(Process&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(output_, other.output_);
  std::swap(buffer_, other.buffer_);
  std::swap(end_, other.end_);
  return *this;
}

Process::~Process() {
  constexpr base::DurationNs kGraceNs = 5 * base::kNsPerS;
  if (id_ > 0 && !end_) Terminate(kGraceNs);
}

std::optional<std::string> Process::ReadLine(base::DurationNs timeout_ns) {
  const std::int64_t deadline_ns = MonotonicNs() + timeout_ns;
  for (;;) {
    const std::size_t end = buffer_.find('\n');
    if (end != std::string::npos || (!output_ && !buffer_.empty())) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end == std::string::npos ? end : end + 1);
      return line;
    }
    if (!output_) return std::nullopt;
    pollfd wait{output_.Get(), POLLIN, 0};
    const timespec left = Timespec(deadline_ns - MonotonicNs());
    const int ready = ppoll(&wait, 1, &left, nullptr);
    if (ready == 0) return std::nullopt;
    std::array<char, 4096> chunk;
    const ssize_t count = ready < 0 ? -1 : read(output_.Get(), chunk.data(), chunk.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      output_.Close();
    } else {
      buffer_.append(chunk.data(), static_cast<std::size_t>(count));
    }
  }
}

std::optional<ProcessEnd> Process::WaitFor(base::DurationNs timeout_ns) {
  if (end_) return end_;
  // A process descriptor becomes readable when its process ends: no SIGCHLD. Some containers forbid it; then
  // a look every few milliseconds does.
  constexpr base::DurationNs kLookNs = 5 * base::kNsPerMs;
  const FileDescriptor descriptor(static_cast<int>(syscall(SYS_pidfd_open, id_, 0)));
  const std::int64_t deadline_ns = MonotonicNs() + timeout_ns;
  int status = 0;
  rusage used{};
  while (wait4(id_, &status, WNOHANG, &used) != id_) {
    const std::int64_t left_ns = deadline_ns - MonotonicNs();
    if (left_ns <= 0) return std::nullopt;
    pollfd wait{descriptor.Get(), POLLIN, 0};
    const timespec timeout = Timespec(descriptor ? left_ns : std::min(left_ns, kLookNs));
    ppoll(&wait, 1, &timeout, nullptr);
  }
  const int exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  end_ = ProcessEnd{exit_code, Ns(used.ru_utime) + Ns(used.ru_stime)};
  return end_;
}

base::DurationNs Process::CpuNs() const {
  if (end_) return end_->cpu_ns;
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(id_, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return used.tv_sec * base::kNsPerS + used.tv_nsec;
}

void Process::SendSignal(int signal) const {
  // Not after its end: the number may belong to somebody else by now.
  if (id_ > 0 && !end_) kill(id_, signal);
}

ProcessEnd Process::Terminate(base::DurationNs grace_ns) {
  SendSignal(SIGTERM);
  std::optional<ProcessEnd> end = WaitFor(grace_ns);
  while (!end) {
    SendSignal(SIGKILL);
    end = WaitFor(base::kNsPerS);
  }
  return *end;
}

}  // namespace adit::linux
