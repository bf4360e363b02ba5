// How far the detection's centroids are from the truth on rendered LEDs, beside the Cramer-Rao bound.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "firmware/detect/blob_set.h"
#include "firmware/optics/camera_model.h"
#include "tests/support/rendered_spots.h"

namespace adit::support {

inline constexpr int kTrialWidthPx = 400, kTrialHeightPx = 320;
inline constexpr double kTrialBackgroundDn = 8;

/// A camera without distortion.
optics::CameraModel Pinhole(int width_px = kTrialWidthPx, int height_px = kTrialHeightPx);

/// The blob nearest to the spot, none further than `within_px`.
const detect::Blob* Nearest(const detect::BlobSet& blobs, const RenderedSpot& spot, double within_px = 3);

/// The Cramer-Rao bound of the places of `spots` (px^2; x, y of the first, then of the next): places, peaks,
/// a common sigma and the background unknown, clipped pixels without information.
Eigen::MatrixXd CramerRaoPx2(const std::vector<RenderedSpot>& spots, const SensorNoise& noise, int bits);

/// One kind of LED, or of two side by side, on one kind of ground.
struct TrialKind {
  double peak_dn = 200, sigma_px = 1.5;
  double smear_px = 0;     ///< length of a movement in any direction
  double gap_px = 0;       ///< to a second LED in any direction; 0: none
  double second_peak = 1;  ///< its peak, in units of the first's
  double slope_dn = 0;     ///< of the ground, a pixel along x; half of it along y
  int bits = 8;
  SensorNoise noise = {};
};

struct TrialErrors {
  int spots = 0, missing = 0, surplus = 0, saturated = 0;  ///< surplus: blobs that are no LED's
  double rms_px = 0;                                       ///< of one coordinate, phase bias included
  double bound_px = 0;                                     ///< Cramer-Rao, the same mean
  double nees = 0;       ///< mean squared normalised error of a place: 2 if the covariance is true
  double offset_px = 0;  ///< length of the mean error

  double PerBound() const { return rms_px / bound_px; }
};

/// `images` of 56 cells with one LED or two each, at random phases. Prints a line.
TrialErrors Measure(const TrialKind& kind, int images, unsigned seed);

}  // namespace adit::support
