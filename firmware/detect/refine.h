// From the moments of a component to the best that is known of an LED's place.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "firmware/base/image.h"
#include "firmware/detect/centroid.h"

namespace adit::detect {

/// Where a spot is, in the image, and how well that is known.
struct SpotPlace {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
};

/// The place of the spot whose moments are `spot`, of `area_px` pixels above `threshold_dn`, from all pixels
/// around it, those of the image that are in no window too. None for what is no lone Gaussian spot of LED
/// size: then the moments are the best there is.
std::optional<SpotPlace> Refine(const base::ImageView& image, const SpotMoments& spot, double area_px,
                                int threshold_dn, const PixelNoise& noise);

}  // namespace adit::detect
