// The luminance-weighted centroid of one bright spot and how well it is known.
#pragma once

#include <Eigen/Core>

#include "firmware/detect/light_sums.h"

namespace adit::detect {

/// Pixel noise, in DN of the image's own bits.
struct PixelNoise {
  double read_dn = 0;
  double electrons_per_dn = 0;
  double background_dn = 0;

  /// Variance of a pixel of that brightness, not darker than the background: read noise, shot noise,
  /// rounding.
  double VarianceDn2(double value_dn) const;
};

/// Moments of a component weighted with the brightness above the threshold.
class SpotMoments {
 public:
  /// From the component's sums about `origin_px`, near the spot, so that they stay small. `threshold_dn` is
  /// not below the background.
  SpotMoments(const LightSums& sums, const Eigen::Vector2i& origin_px, int threshold_dn,
              const PixelNoise& noise)
      : origin_px_(origin_px), threshold_dn_(threshold_dn), noise_(noise), sums_(sums) {}

  Eigen::Vector2d CentroidPx() const;
  /// Of the centroid: the pixels' noise through the weights, and what the cut-off at the threshold leaves.
  Eigen::Matrix2d CovariancePx2() const;
  /// Square roots of the eigenvalues of the second moments, larger first.
  Eigen::Vector2d SigmasPx() const;
  /// Second moments of the spot if it is a Gaussian: their ratios as above the threshold, their size from the
  /// pixels there.
  Eigen::Matrix2d GaussianShapePx2() const;
  double PeakDn() const { return threshold_dn_ + sums_.most; }
  /// Sum of the brightness above the background.
  double FluxDn() const { return sums_.light.g + sums_.ones.g * (threshold_dn_ - noise_.background_dn); }

 private:
  Eigen::Matrix2d SecondMomentsPx2() const;
  double Cut() const;              ///< threshold / peak, above the background
  double GaussianSizePx2() const;  ///< geometric mean of a Gaussian's second moments

  Eigen::Vector2i origin_px_;
  int threshold_dn_;
  PixelNoise noise_;
  LightSums sums_;
};

}  // namespace adit::detect
