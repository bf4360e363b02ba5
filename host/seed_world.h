// The rigs, bars and movements of the seed's chapter 5, with simulated centroids. Projection and lens are the
// simulator's own.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "drivers/sim/random.h"
#include "firmware/base/target.h"
#include "firmware/detect/blob_set.h"
#include "firmware/optics/rig.h"
#include "host/intrinsic_prior.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// A rig and how it is calibrated.
struct SeedSetup {
  double base_m = 9, converge_m = 35;
  base::Target bar;                        ///< waved for the calibration
  double nearest_m = 15, farthest_m = 30;  ///< where
  std::size_t frames = 1100;
  double bar_sigma_m = 1e-4;  ///< how well the bar's length is known; every calibration has its own bar
  double noise_px = 0;        ///< of a centroid's raw coordinate
  /// What the camera files are off by; every calibration has its own, and refines them.
  IntrinsicSigmas lens = {0, 0, 0};
};

/// Where a bar is.
struct BarPose {
  Eigen::Vector3d led1_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::UnitX();

  Eigen::Vector3d Point(double place_m) const { return led1_b_m + place_m * direction_b; }
};

/// x along the baseline, z ahead, between the cameras: the frame in which the seed's distances are told.
struct MiddleFrame {
  explicit MiddleFrame(const optics::Rig& rig);
  Eigen::Matrix3d R_b_m;
  Eigen::Vector3d origin_b_m;

  Eigen::Vector3d InRig(const Eigen::Vector3d& point_m_m) const { return origin_b_m + R_b_m * point_m_m; }
};

/// Raw pixels of LED 1 to LED 4, left then right.
using BarPixels = std::array<std::array<Eigen::Vector2d, base::kLedCount>, 2>;
/// None if an LED is outside an image or within 5 px of its border. `length_scale` stretches the bar.
std::optional<BarPixels> PixelsOf(const optics::Rig& rig, const base::Target& target, const BarPose& pose,
                                  double length_scale = 1);

/// Draws all that is random.
class SeedDraw {
 public:
  SeedDraw(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}

  double Uniform(double from, double to) { return random_.Uniform(from, to); }
  double Normal();
  /// A bar that both cameras see entirely, anywhere in the volume, its direction's z within 0.7.
  BarPose Wave(const optics::Rig& rig, const SeedSetup& setup, double length_scale);
  /// The bar with its tip (`target.epicenter_m`) at a place of the middle frame, yaw, pitch and roll of 0 to
  /// 45 degrees from upright.
  BarPose TurnedAboutTip(const MiddleFrame& frame, const base::Target& target,
                         const Eigen::Vector3d& tip_m_m);
  /// A camera file that is off by as much as its prior says.
  optics::CameraModel Mistaken(const optics::CameraModel& truth, const IntrinsicPrior& prior);
  /// Pixels with noise.
  BarPixels Noisy(const BarPixels& pixels, double noise_px);

 private:
  sim::Random random_;
};

/// What a detection would hand on of these pixels: centroids undistorted for the cameras of `rig` by code of
/// the simulator's, with their covariance.
StereoBar StereoBarOf(const optics::Rig& rig, const BarPixels& pixels, double noise_px);
void FillBlobs(const optics::Rig& rig, const BarPixels& pixels, double noise_px,
               std::array<detect::BlobSet, 2>& blobs);

}  // namespace adit::host
