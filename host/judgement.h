// One reported position against the truth of its moment.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/sim/world.h"
#include "firmware/stereo/point_set.h"

namespace adit::host {

enum class Outcome : std::uint8_t {
  kLost,     ///< no position; says nothing of whether there should be one
  kFound,    ///< within five stated standard deviations and 10 mm
  kOff,      ///< farther off than that
  kSwapped,  ///< nearer to the LEDs of another target than to its own, or its LEDs in the wrong order
};

struct Judgement {
  Outcome outcome = Outcome::kLost;
  double error_m = 0;  ///< of the epicenter
  /// Squared error in units of the stated covariance, 3 degrees of freedom.
  double nees = 0;
};

/// How far off a position may be: 5 stated standard deviations along the error, and 10 mm.
inline constexpr double kOffSigmas = 5, kOffFloorM = 0.010;

/// Judges what was reported of `own`, one of `all`. The name is wrong when the reported LEDs together are
/// nearer to those of another target, or to its own in reversed order.
Judgement Judge(const stereo::TargetPoints& reported, const sim::TargetTruth& own,
                std::span<const sim::TargetTruth> all);

}  // namespace adit::host
