// From the moments of a component to the best that is known of the places of its LEDs.
#pragma once

#include <Eigen/Core>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/image.h"
#include "firmware/detect/components.h"
#include "firmware/detect/spot_fit.h"

namespace adit::detect {

/// Where an LED is, in the image, and how well that is known.
struct LedPlace {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  double height_dn = 0;  ///< of its middle above the background
  double sigma_px = 0;   ///< its width where it is narrowest
};

/// One LED, two that merged, or none: no spot of LED size and shape, or company so near that the moments are
/// the best there is.
using LedPlaces = base::FixedVector<LedPlace, 2>;

/// The LEDs in `component`, whose moments above `threshold_dn` are `spot`, from all pixels around it: those
/// of the image that are in no window too.
LedPlaces Refine(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                 int threshold_dn, const PixelLimits& pixels);

}  // namespace adit::detect
