// What the uncertainty of a rig does to the positions measured with it (as mrcal propagates it).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "firmware/optics/rig.h"

namespace adit::host {

/// `rig` with its parameters moved by `step`, in the order of RigCovariance.
optics::Rig Moved(const optics::Rig& rig, const Eigen::Matrix<double, optics::kRigParameters, 1>& step);

/// Raw centroids of one point in both images.
struct RawPair {
  Eigen::Vector2d left_px = Eigen::Vector2d::Zero(), right_px = Eigen::Vector2d::Zero();
};

/// Where `rig` has the point that shows at `pair`, left camera frame. Declines parallel rays and pixels
/// outside the lens model.
std::optional<Eigen::Vector3d> Locate(const optics::Rig& rig, const RawPair& pair);

/// d place / d rig parameters (by central differences) and d place / d (left u, v, right u, v).
struct PlaceDerivatives {
  Eigen::Matrix<double, 3, optics::kRigParameters> by_rig;
  Eigen::Matrix<double, 3, 4> by_pixel;
};
std::optional<PlaceDerivatives> DerivativesOf(const optics::Rig& rig, const RawPair& pair);

/// One standard deviation of a point in the directions of view: across (level), up, and along.
struct RigPrediction {
  double distance_m = 0;
  double across_m = 0, up_m = 0, depth_m = 0;  ///< from the calibration
  double noise_depth_m = 0;                    ///< of one LED, from `noise_px`
  double depth_per_yaw_m_rad = 0;              ///< yaw sensitivity: depth by relative yaw
  double depth_per_px_m = 0;                   ///< range sensitivity: depth by one pixel of disparity
};

/// Of a point of the left camera's frame; its distance is that from the middle of the baseline. Declines
/// where not both cameras look.
std::optional<RigPrediction> PredictAt(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                       const Eigen::Vector3d& point_l_m, double noise_px);

/// The same straight ahead of the rig.
std::optional<RigPrediction> Predict(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                     double distance_m, double noise_px);

}  // namespace adit::host
