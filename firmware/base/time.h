// Time as adit carries it: nanoseconds of one clock, the box clock.
#pragma once

#include <cstdint>

namespace adit::base {

/// Nanoseconds since the Unix epoch on the box clock (CLOCK_REALTIME on a box, disciplined by PTP or NTP).
/// Every variable of this type ends in `_ns`, and its name says which event it dates.
using TimeNs = std::int64_t;

/// A difference of two TimeNs.
using DurationNs = std::int64_t;

inline constexpr DurationNs kNsPerUs = 1'000;
inline constexpr DurationNs kNsPerMs = 1'000'000;
inline constexpr DurationNs kNsPerS = 1'000'000'000;

/// The time of an event that has not happened.
inline constexpr TimeNs kNever = INT64_MIN;

}  // namespace adit::base
