// A bar that both cameras identified: the raw material of the calibration.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "firmware/base/target.h"
#include "firmware/base/time.h"

namespace adit::host {

/// One LED in one image.
struct LedView {
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();  ///< centroid, undistorted
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

using BarView = std::array<LedView, base::kLedCount>;  ///< LED 1 to LED 4

/// One target in both images of a pair. Each image was searched on its own, so a bar may be a wrong pair; one
/// frame may hold several candidates of one target.
struct StereoBar {
  base::TimeNs mid_exposure_ns = 0;
  std::uint8_t target = 0;  ///< index into the target list
  BarView left, right;
};

}  // namespace adit::host
