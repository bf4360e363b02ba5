// Child processes: start, read what they print, stop, and what they cost.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/file_descriptor.h"
#include "firmware/base/result.h"
#include "firmware/base/time.h"

namespace adit::linux {

/// How a child ended.
struct ProcessEnd {
  int exit_code = 0;            ///< 128 + signal if a signal ended it, as shells count
  base::DurationNs cpu_ns = 0;  ///< user and system time, with its own waited-for children (getrusage)
};

/// Where a child's output goes.
struct ProcessOutput {
  bool capture_stdout = true;  ///< readable with ReadLine; false: the parent's stdout
  std::string stderr_path;     ///< appended to this file; empty: the parent's stderr
};

/// One child. Its signal mask is empty and its signal actions are the default, whatever the parent's are. All
/// calls belong to one thread. Destruction terminates a child that still runs.
class Process {
 public:
  /// Starts `arguments[0]` (searched in PATH). Declines with kNotFound or kFailed, naming it.
  static base::Result<Process> Spawn(const std::vector<std::string>& arguments, ProcessOutput output = {});

  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  ~Process();

  pid_t Id() const { return id_; }
  /// The next line of its stdout without the line end, waiting at most `timeout_ns`; nothing after the
  /// timeout, or when it closed its stdout (OutputEnded). A last line without end counts.
  std::optional<std::string> ReadLine(base::DurationNs timeout_ns);
  bool OutputEnded() const { return !output_ && buffer_.empty(); }
  /// Waits at most `timeout_ns` for its end; nothing if it still runs. Zero only looks. It may be asked
  /// again.
  std::optional<ProcessEnd> WaitFor(base::DurationNs timeout_ns);
  /// CPU time so far of a child that runs, or its total.
  base::DurationNs CpuNs() const;
  void SendSignal(int signal) const;
  /// SIGTERM, and SIGKILL if it has not ended after `grace_ns`.
  ProcessEnd Terminate(base::DurationNs grace_ns);

 private:
  Process(pid_t id, FileDescriptor output) : id_(id), output_(std::move(output)) {}
  pid_t id_ = -1;
  FileDescriptor output_;
  std::string buffer_;
  std::optional<ProcessEnd> end_;
};

}  // namespace adit::linux
