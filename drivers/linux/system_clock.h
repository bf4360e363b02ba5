// The box clock on Linux.
#pragma once

#include "hal/clock.h"

namespace adit::linux {

/// CLOCK_REALTIME, which PTP or NTP disciplines. It can be stepped: waits and timeouts take MonotonicNs.
class SystemClock final : public hal::Clock {
 public:
  base::TimeNs Now() const override;
};

/// CLOCK_MONOTONIC, for waits and durations: never stepped, its zero means nothing.
std::int64_t MonotonicNs();

}  // namespace adit::linux
