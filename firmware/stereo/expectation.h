// Where a target is expected in a pair that was not yet looked at: what makes three or two LEDs enough to
// confirm it.
#pragma once

#include <Eigen/Core>
#include <array>

#include "firmware/stereo/point_set.h"

namespace adit::stereo {

/// One target, rig frame, at the exposure of the pair to be located. Neither known nor recent: the rest is
/// empty.
struct Expectation {
  bool known = false;   ///< without a lock nothing is expected
  bool recent = false;  ///< no lock, but seen a moment ago: tells what may be a reflection, and nothing else
  Eigen::Vector3d led1_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::UnitX();  ///< unit, LED 1 to LED 4
  /// Of (led1_b_m, direction_b), process noise up to the exposure included; the direction's part has rank 2.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  LedFlux flux_dn{};  ///< as last seen
};

/// By index of the target.
using ExpectationSet = std::array<Expectation, identify::kMaxTargets>;

}  // namespace adit::stereo
