#include "drivers/linux/system_clock.h"

#include <time.h>

namespace adit::linux {
namespace {

std::int64_t ReadClock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);  // through the vDSO, no system call; cannot fail for these two clocks
  return now.tv_sec * base::kNsPerS + now.tv_nsec;
}

}  // namespace

base::TimeNs SystemClock::Now() const { return ReadClock(CLOCK_REALTIME); }

std::int64_t MonotonicNs() { return ReadClock(CLOCK_MONOTONIC); }

}  // namespace adit::linux
