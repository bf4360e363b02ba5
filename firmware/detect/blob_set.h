// What the detection hands on: every bright spot of one image that could be an LED.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/image.h"
#include "firmware/detect/window.h"

namespace adit::detect {

inline constexpr std::size_t kMaxBlobs = 512;  ///< candidates kept per image; more are counted, not kept

/// One connected bright region that passed size and shape, or one of two LEDs that merged in it.
struct Blob {
  Eigen::Vector2d raw_px = Eigen::Vector2d::Zero();          ///< centroid in the image as taken
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();        ///< the same without lens distortion
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< of ideal_px: noise of the pixels, propagated
  float flux_dn = 0;                             ///< sum of the brightness above the local background
  float peak_dn = 0;                             ///< brightest pixel, background included
  float background_dn = 0;                       ///< local background that was subtracted
  float area_px = 0;                             ///< pixels above the threshold
  float sigma_major_px = 0, sigma_minor_px = 0;  ///< square roots of the eigenvalues of the second moments
  std::uint16_t x_min_px = 0, y_min_px = 0, x_max_px = 0, y_max_px = 0;  ///< bounding box, inclusive
  bool saturated = false;                                                ///< at least one pixel at full scale
  /// One of two LEDs in one region, fitted together. Area and box are those of the region, flux, peak and
  /// sigmas those of the fit; `covariance_px2` has what either leaves open of the other, but the two errors
  /// are not independent.
  bool merged = false;
};

/// Boxes kept of what is too large, not round or at the border: room for every lamp of a tunnel.
inline constexpr std::size_t kMaxRegions = 256;

/// Why components were left out, counted per image.
struct BlobRejects {
  std::uint32_t too_small = 0;
  std::uint32_t too_large = 0;
  std::uint32_t not_round = 0;
  std::uint32_t at_border = 0;
  std::uint32_t no_room = 0;  ///< more than kMaxBlobs candidates, or segmentation capacity exceeded
};

/// All LED candidates of one image, in scan order. status != kOk in the stamp means: no blobs were sought.
struct BlobSet {
  base::FrameStamp stamp;
  bool whole = true;  ///< the whole image was searched, not windows of it
  base::FixedVector<Blob, kMaxBlobs> blobs;
  BlobRejects rejects;
  /// Where something bright is that is no blob: an LED may have merged with it. What is too small is not
  /// here, and what does not fit is missing.
  base::FixedVector<Window, kMaxRegions> regions;
  float background_dn = 0;  ///< of the whole image
  float noise_dn = 0;       ///< standard deviation of the background
  float threshold_dn = 0;   ///< brightness above which a pixel is bright
};

}  // namespace adit::detect
