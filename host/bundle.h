// Bundle adjustment of a rig: relative pose, intrinsics, bar lengths and all bars, each one rigid line, to
// all measured centroids.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/optics/rig.h"
#include "host/essential.h"
#include "host/intrinsic_prior.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// Where a bar is: the mean of its LEDs, and the unit direction LED 1 -> LED 4; left camera frame.
struct BarPlace {
  Eigen::Vector3d centre_l_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_l = Eigen::Vector3d::UnitX();
};

/// Two cameras and what is known of them before, and the known bars.
struct BundleSetting {
  optics::CameraModel left, right;         ///< as their files say; the priors' means
  IntrinsicPrior left_prior, right_prior;  ///< exact ones are not adjusted
  std::vector<base::Target> targets;
  double bar_sigma_m =
      0;  ///< standard deviation of a bar's length, which scales all its LED places; 0: exact
  double noise_scale = 1;  ///< the centroids are this much worse than their covariances say
};

struct BundleData {
  std::span<const StereoBar> bars;
  std::span<const StereoPoint> points = {};
};

/// Everything that is adjusted.
struct BundleState {
  optics::CameraModel left, right;
  RelativePose T_r_l;                       ///< metres; the LED distances are the scale
  std::vector<double> length_scale;         ///< one a target: true over stated length
  std::vector<BarPlace> places;             ///< one a bar
  std::vector<Eigen::Vector3d> points_l_m;  ///< one a point
};

struct Bundle {
  BundleState state;
  std::vector<double> chi2;       ///< one a bar: 16 residuals whitened by the centroids' covariances, squared
  std::vector<double> error_px2;  ///< one a bar: the same in pixels
  std::vector<double> point_chi2;  ///< one a point: 4 residuals
  /// By the order of optics::RigCovariance, at `noise_scale`. Empty if the data leave a direction free.
  std::optional<optics::RigCovariance> covariance;
};

/// How the bars' residuals count.
enum class BundleLoss {
  kRobust,  ///< Cauchy on each bar's chi2: while wrong pairs may be among them
  kLeast,   ///< least squares: all bars are right; fills `covariance`
};

/// Where a bar is by given cameras: each LED on its own, then the best line. Declines parallel rays and LEDs
/// behind a camera.
std::optional<BarPlace> PlaceBar(const optics::Rig& rig, const StereoBar& bar, const base::Target& target);

/// Minimises over 6 + 2 x 8 + targets + 5 n + 3 m parameters (Triggs et al. 2000; Ceres, Schur complement on
/// bars and points), from `start`. Intrinsics and bar lengths count as measured with their priors. Declines
/// if the solver does not converge or ends with values that are not finite.
std::optional<Bundle> AdjustBundle(const BundleSetting& setting, const BundleData& data,
                                   const BundleState& start, BundleLoss loss);

}  // namespace adit::host
