// Bundle adjustment of a rig: relative pose and all bars, each one rigid line, to all measured centroids.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/optics/camera_model.h"
#include "host/essential.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// Where a bar is: the mean of its LEDs, and the unit direction LED 1 -> LED 4; left camera frame.
struct BarPlace {
  Eigen::Vector3d centre_l_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_l = Eigen::Vector3d::UnitX();
};

struct BundleInput {
  const optics::CameraModel& left;
  const optics::CameraModel& right;
  std::span<const base::Target> targets;
  std::span<const StereoBar> bars;
};

struct Bundle {
  RelativePose T_r_l;             ///< metres; the LED distances are the scale
  std::vector<BarPlace> places;   ///< one a bar
  std::vector<double> chi2;       ///< one a bar: 16 residuals whitened by the centroids' covariances, squared
  std::vector<double> error_px2;  ///< one a bar: the same in pixels
  /// Of (rotation vector in the right camera's frame: rad, translation: m), R = exp(w) R^; from the
  /// centroids' covariances as given. Empty if the bars leave a direction of the pose free.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
};

/// How the bars' residuals count.
enum class BundleLoss {
  kRobust,  ///< Cauchy on each bar's chi2: while wrong pairs may be among them
  kLeast,   ///< least squares: all bars are right; fills `covariance`
};

/// Where a bar is by a given pose: each LED on its own, then the best line. Declines parallel rays and LEDs
/// behind a camera.
std::optional<BarPlace> PlaceBar(const BundleInput& input, const RelativePose& T_r_l, const StereoBar& bar);

/// Minimises over 6 + 5 n parameters (Triggs et al. 2000; Ceres, Schur complement on the bars), from `start`
/// and `places` (as many as bars). Declines if the solver does not converge or ends with values that are not
/// finite.
std::optional<Bundle> AdjustBundle(const BundleInput& input, const RelativePose& start,
                                   std::span<const BarPlace> places, BundleLoss loss);

}  // namespace adit::host
