// What no estimator can do better: the Cramer-Rao bound of a wand calibration, and of a position measured
// with the calibrated rig. Derivatives by differences of the simulator's projection; nothing of the
// calibration or the stereo stage is used.
#pragma once

#include <Eigen/Core>
#include <span>

#include "host/seed_world.h"

namespace adit::host {

/// Of (rotation vector about the right camera: rad, translation: m), as in optics::RigCovariance.
using PoseInformation = Eigen::Matrix<double, 6, 6>;

/// What one sight of a bar with centroids of 1 px tells of the relative pose, the lenses known and the bar's
/// own place unknown: inverse of a covariance, addable.
PoseInformation BarInformation(const optics::Rig& rig, const base::Target& target, const BarPose& pose);

/// The bound of pose and intrinsics (CalibrationBound): all bars of a wand, its length known to `bar_sigma_m`
/// and the lenses to `lens`.
optics::RigCovariance WandBound(const optics::Rig& rig, const SeedSetup& setup,
                                std::span<const BarPose> poses);

/// What is reachable at a place, one standard deviation, over calibrations and frames.
struct PlaceBound {
  double bar_bias_m = 0;   ///< mean error of the bar length LED 1 to LED 4, from LEDs each on their own
  double bar_sigma_m = 0;  ///< spread of the same from frame to frame
  double half_bar_m = 0;   ///< of the seed's xRMS(P)
  double position_m = 0;   ///< mean error of the epicenter, three dimensions, rigid bar
  Eigen::Vector3d sigma_m =
      Eigen::Vector3d::Zero();  ///< spread of the epicenter, its own movement included; middle frame
};

/// Over the frames of one place: `poses` of `target`.
PlaceBound BoundAt(const optics::Rig& rig, const optics::RigCovariance& calibration,
                   const base::Target& target, std::span<const BarPose> poses, double noise_px);

}  // namespace adit::host
