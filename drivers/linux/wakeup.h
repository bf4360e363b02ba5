// One thread sleeps until another has something for it.
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/base/time.h"

namespace adit::linux {

/// A signal that stays until it is taken. Signal may be called by any number of threads, WaitFor by one.
/// Signals coalesce: several before a wait wake it once, so the waiter looks for all its work after each.
/// Neither call locks or allocates; Signal is a system call only when the waiter really sleeps (futex(2),
/// private).
class Wakeup {
 public:
  Wakeup() = default;
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  /// Wakes the waiter, or makes its next WaitFor return at once. What this thread wrote before is visible to
  /// it then.
  void Signal();

  /// True once a signal is there (and takes it), false after `timeout_ns` without one. Zero only looks.
  bool WaitFor(base::DurationNs timeout_ns);

 private:
  enum State : std::uint32_t { kIdle, kSleeping, kSignalled };
  std::atomic<std::uint32_t> state_{kIdle};
};

}  // namespace adit::linux
