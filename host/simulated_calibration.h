// Calibrations with known truth: a rig, cameras whose files are wrong, and waved bars, projected by code of
// its own. With it, the Cramer-Rao bound of what such bars can tell.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/sim/random.h"
#include "host/calibration.h"

namespace adit::host {

/// In the order of optics::RigCovariance.
using RigVector = Eigen::Matrix<double, optics::kRigParameters, 1>;

/// What is calibrated, and by what.
struct CalibrationPlan {
  double base_m = 9, converge_m = 35;
  std::array<double, base::kLedCount> leds_m{0, 0.25, 0.53, 0.82};
  std::size_t bars = 1100;
  double nearest_m = 15, farthest_m = 30;
  double far_share = 0, farthest_far_m = 100;  ///< so many of the bars between `farthest_m` and this
  double lean_max = 0.7;                       ///< of the direction's z
  double noise_px = 0.01;
  IntrinsicSigmas intrinsics;   ///< what the camera files are wrong by
  double bar_sigma_m = 0.1e-3;  ///< what the bar is wrong by
};

/// fu, fv, cu, cv (px), k1, k2, p1, p2 of both cameras; x_r = R x_l + t.
struct TrueRig {
  IntrinsicVector left, right;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  /// Left u, v, right u, v; not finite behind a camera.
  Eigen::Vector4d Project(const Eigen::Vector3d& point_m) const;
  /// The parameters moved.
  TrueRig Moved(const RigVector& step) const;
  optics::Rig AsRig() const;
};

/// 1400 x 1024 px, f = 3378 px, both axes meeting `converge_m` ahead, lens distortion of 8 px in the corner.
TrueRig MakeTrueRig(double base_m, double converge_m);

struct TrueBar {
  Eigen::Vector3d led1_m, direction;
};

/// One calibration to be: truth, and what the tools get.
struct CalibrationDraw {
  TrueRig rig;
  double length_scale = 1;  ///< true over stated length of the bar
  std::vector<TrueBar> bars;
  CalibrationInput input;
};

double Gauss(sim::Random& random);
CalibrationDraw Draw(const CalibrationPlan& plan, std::uint64_t seed);
/// A bar of the plan that both cameras see whole, LED 1 between these distances.
TrueBar WaveBar(const CalibrationPlan& plan, const TrueRig& rig, const Eigen::Vector2d& distance_m,
                sim::Random& random);
/// The same at `distance_m`, its four LEDs measured.
std::array<Eigen::Vector4d, base::kLedCount> Seen(const TrueRig& rig, const TrueBar& bar,
                                                  const std::array<double, base::kLedCount>& leds_m);

}  // namespace adit::host
