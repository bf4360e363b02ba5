// SIGINT and SIGTERM as something to wait for.
#pragma once

#include <signal.h>

#include "drivers/linux/file_descriptor.h"
#include "firmware/base/time.h"

namespace adit::linux {

/// While it lives, SIGINT and SIGTERM no longer end the process but are kept here. Make it in main before any
/// other thread starts: threads inherit the mask, and one without it would die of the signal. One per
/// process.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Waits at most `timeout_ns` for a signal; true from the first one on. Zero only looks. Belongs to the
  /// thread that made it.
  bool WaitFor(base::DurationNs timeout_ns);
  /// Readable when a signal is there, for poll(2).
  int Descriptor() const { return descriptor_.Get(); }

 private:
  sigset_t previous_{};
  FileDescriptor descriptor_;
  bool stopped_ = false;
};

}  // namespace adit::linux
