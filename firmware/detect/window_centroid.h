// The centroid of a spot through a Gaussian window of the spot's own shape.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "firmware/detect/centroid.h"
#include "firmware/detect/spot_patch.h"

namespace adit::detect {

/// A spot as a Gaussian on an even background.
struct GaussianSpot {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< in the image
  Eigen::Matrix2d shape_px2 = Eigen::Matrix2d::Zero();  ///< its second central moments
  double height_dn = 0;                                 ///< of its middle above the background
};

/// The spot in `patch` seen through the window `start`: first and second moments of light times window are
/// those of a product of two Gaussians, from which the spot's own follow (adaptive moments; Bernstein and
/// Jarvis 2002, section 3). Exact whatever the window where the spot is a Gaussian; least noisy where both
/// have one shape. None if the moments are not those of a spot not much larger or smaller than the window.
std::optional<GaussianSpot> ThroughWindow(const SpotPatch& patch, const GaussianSpot& start);

/// Covariance of the centre that ThroughWindow gives for a window of the spot's own shape: the pixels' noise
/// through the window. 1.02 x the Cramer-Rao bound for 200 DN of 40 electrons each, less for dimmer ones.
Eigen::Matrix2d CovarianceThroughWindow(const GaussianSpot& spot, const PixelNoise& noise);

}  // namespace adit::detect
