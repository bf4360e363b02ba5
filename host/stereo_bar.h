// A bar that both cameras identified: the raw material of the calibration.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <tuple>

#include "firmware/base/target.h"
#include "firmware/base/time.h"

namespace adit::host {

/// One LED in one image.
struct LedView {
  Eigen::Vector2d raw_px = Eigen::Vector2d::Zero();              ///< centroid in the image as taken
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();            ///< undistorted with the camera file
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< of ideal_px
};

using BarView = std::array<LedView, base::kLedCount>;  ///< LED 1 to LED 4

/// One target in both images of a pair. Each image was searched on its own, so a bar may be a wrong pair; one
/// frame may hold several candidates of one target.
struct StereoBar {
  base::TimeNs mid_exposure_ns = 0;
  std::uint8_t target = 0;  ///< index into the target list
  BarView left, right;
  std::uint16_t recording = 0;  ///< index into the recordings
};

/// Recording, mid-exposure, target: of all candidates with one key at most one is right.
using BarKey = std::tuple<std::uint16_t, base::TimeNs, std::uint8_t>;
inline BarKey KeyOf(const StereoBar& bar) { return {bar.recording, bar.mid_exposure_ns, bar.target}; }

/// A lamp or LED at rest that both cameras saw, its place unknown; averaged over the frames.
struct StereoPoint {
  LedView left, right;
};

}  // namespace adit::host
