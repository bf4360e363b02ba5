// How the rig stands in the site grid, as a file.
#pragma once

#include <Eigen/Core>
#include <string>

#include "firmware/base/pose.h"
#include "firmware/base/result.h"

namespace adit::georef {

/// The absolute orientation of the rig: p_s = t + diag(k, k, 1) R p_b with T_s_b = (R, t). The grid scale
/// factor k shortens what lies in the plane, as the projection of the grid does; heights keep their length.
struct AbsoluteOrientation {
  base::Pose<base::Site, base::Rig> T_s_b;
  double grid_scale_factor = 1;
  /// The point (metres) that the covariance's translation is of: the centroid of the control points, where
  /// rotation and translation hardly depend on each other.
  Eigen::Vector3d reference_b_m = Eigen::Vector3d::Zero();
  /// Of (rotation vector in the site frame: rad, translation of the reference point: m).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::string calibration_id = "unnamed";  ///< of the rig whose frame b is

  /// p_s of a point of the rig frame; metres.
  Eigen::Vector3d Apply(const Eigen::Vector3d& point_b_m) const;
  /// The unit direction in the site frame of a direction in the rig frame.
  Eigen::Vector3d Turn(const Eigen::Vector3d& direction_b) const;
  /// The covariance of p_s: of the point in the rig frame, and of the orientation itself.
  Eigen::Matrix3d Propagate(const Eigen::Vector3d& point_b_m, const Eigen::Matrix3d& covariance_b_m2) const;
};

/// Reads the file of `adit georef`. `calibration_id` is the rig's: an orientation that was made with another
/// calibration is refused, because its rig frame is another one. So are one made with 7 parameters (for
/// diagnosis only), a rotation that is none, a grid scale factor outside 0.99 to 1.01 and a covariance that
/// is not symmetric or has negative variances. Errors name file, key, value and what is allowed.
base::Result<AbsoluteOrientation> LoadOrientation(const std::string& path, const std::string& calibration_id);

/// The keys that LoadOrientation needs, as YAML text, for `parameters` (4, 6 or 7) estimated with `scale`.
std::string FormatOrientation(const AbsoluteOrientation& orientation, int parameters, double scale);

}  // namespace adit::georef
