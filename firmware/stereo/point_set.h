// What the stereo stage hands on: where the LEDs of each target are.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/pose.h"
#include "firmware/identify/sighting_set.h"

namespace adit::stereo {

/// Which blobs of an image are LED 1 to LED 4; kNoBlob where an LED is hidden.
using BlobIndices = std::array<std::uint16_t, base::kLedCount>;
inline constexpr std::uint16_t kNoBlob = 0xFFFF;
/// In the left image and in the right one.
using BarBlobs = std::array<BlobIndices, 2>;

/// Brightness of LED 1 to LED 4 in the left image and in the right one, sums of DN; 0 where none is known.
using LedFlux = std::array<std::array<float, base::kLedCount>, 2>;

/// A lamp half as bright as the LED that it merges with makes it 1.5 times as bright.
inline constexpr float kSameMake = 1.25F;
/// Of one LED beside the others nothing but noise, a hundredth, and a leaning bar's ends make a difference.
inline constexpr float kSameLed = 1.1F;

/// Whether LEDs are as bright, one beside another, as they are known to be: `within` that, after a common
/// factor (exposure, distance). Of an LED that is not known yet it is expected that it is like the others of
/// its image: they are of one type and look one way. One that is not has merged with a lamp or is covered in
/// part, and its centroid is not where the LED is; or it is none.
bool SameBrightness(const LedFlux& known, const LedFlux& seen, float within = kSameMake);

/// The same of one LED beside the others of one image, within a tenth: of an LED that only this image shows.
/// What hides it from one camera stands near the other's line of sight too and may cover a part of it, which
/// moves its centroid by more than the noise long before a quarter of its light is gone.
bool IsUncovered(const LedFlux& known, const LedFlux& seen, std::size_t side, std::size_t led);

enum class FixStatus : std::uint8_t {
  kTracked,    ///< all four LEDs measured in both images
  kRecovered,  ///< one or two LEDs rebuilt from the others: hidden in one image or in both
  kPredicted,  ///< by the filter alone
  kLost,       ///< no position
};

/// Why a target has no position.
enum class LossReason : std::uint8_t {
  kNone,
  kNoFrame,           ///< a camera delivered no usable frame
  kNotSeen,           ///< no four blobs in the left image pass for it, nor three LEDs in both
  kNoCorrespondence,  ///< the right image does not confirm them along the epipolar lines
  kDistances,         ///< the LEDs found are not the right distances apart
  kAmbiguous,         ///< several places pass equally well
  kGeometry,          ///< no stable solution: behind the cameras or not converged
  kOneBar,            ///< a body of which one bar is seen: five degrees of freedom
  kJump,              ///< not where the track allows it to be, and not yet seen there twice
};

/// One target of one pair. All in the rig frame b (the left camera), metres. Empty (zero) unless status says
/// otherwise: look at the status first.
struct TargetPoints {
  std::uint8_t target = 0;
  FixStatus status = FixStatus::kLost;
  LossReason reason = LossReason::kNotSeen;
  std::array<Eigen::Vector3d, base::kLedCount> leds_b_m =
      base::ZeroPoints<base::kLedCount>();                  ///< each LED on its own; rebuilt: from the fit
  Eigen::Vector3d epicenter_b_m = Eigen::Vector3d::Zero();  ///< from the rigid bar fit
  Eigen::Matrix3d epicenter_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::Zero();           ///< unit, LED 1 to LED 4
  Eigen::Matrix3d direction_covariance = Eigen::Matrix3d::Zero();  ///< rank 2
  /// Of the epicenter (rows) with the direction (columns): a tip beyond the LEDs goes where the bar turns.
  Eigen::Matrix3d epicenter_direction_covariance_m = Eigen::Matrix3d::Zero();
  double bar_m = 0;  ///< distance LED 1 to LED 4 of `leds_b_m`: measured, unless one of them was rebuilt
  double bar_sigma_m = 0;
  double reprojection_px = 0;       ///< rms over the rigid fit's image residuals
  std::uint8_t recovered_mask = 0;  ///< bit i: LED i+1 was rebuilt
  BarBlobs blobs{};                 ///< LED 1 to LED 4 in the left image's blobs and in the right one's
  LedFlux flux_dn{};                ///< of these blobs
};

/// One entry for every target of the model list, in its order, found or lost.
struct PointSet {
  base::FrameStamp
      stamp;  ///< of the left image (the right, if the left is undated); last_packet_ns: the later one's
  const identify::SightingSet* left = nullptr;
  const identify::SightingSet* right = nullptr;
  base::FixedVector<TargetPoints, identify::kMaxTargets> targets;
};

}  // namespace adit::stereo
