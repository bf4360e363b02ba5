// Sums over the pixels of a bright region: what the moments of a spot are made of.
#pragma once

#include <Eigen/Core>

#include "firmware/base/image.h"
#include "firmware/detect/components.h"

namespace adit::detect {

/// Sums over pixels: of a weight g, and of g times their places. Whole numbers or halves, and exact, as a
/// thousand pixels of 16 bits a thousand pixels from the origin come to 7e13.
struct MomentSums {
  double g = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

struct LightSums {
  MomentSums light;  ///< weighted with the brightness above the threshold, DN
  MomentSums ones;   ///< weighted with 1
  double most = 0;   ///< the brightest pixel above the threshold, DN
};

/// Of the runs, all of whose pixels are brighter than `threshold_dn`, with places counted from `origin_px`.
LightSums SumLight(const base::ImageView& image, const RunList& runs, const Eigen::Vector2i& origin_px,
                   int threshold_dn);

}  // namespace adit::detect
