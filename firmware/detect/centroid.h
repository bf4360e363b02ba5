// The luminance-weighted centroid of one bright spot and how well it is known.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "firmware/base/image.h"
#include "firmware/detect/components.h"

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

/// Sums over pixels: of a weight g, and of g times their places. Whole numbers: a thousand pixels of 16 bits
/// a thousand pixels from the origin come to 7e13.
struct MomentSums {
  std::int64_t g = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// Moments of a component weighted with the brightness above the threshold. Take every run of the component
/// once, in any order; then ask.
class SpotMoments {
 public:
  /// `threshold_dn` is not below the background. Sums are taken about `origin_px`, near the spot, so that
  /// they stay small.
  SpotMoments(const Eigen::Vector2i& origin_px, int threshold_dn, const PixelNoise& noise)
      : origin_px_(origin_px), threshold_dn_(threshold_dn), noise_(noise) {}

  void Take(const base::ImageView& image, const Run& run);

  Eigen::Vector2d CentroidPx() const;
  /// Of the centroid: the pixels' noise through the weights, and what the cut-off at the threshold leaves.
  Eigen::Matrix2d CovariancePx2() const;
  /// Square roots of the eigenvalues of the second moments, larger first.
  Eigen::Vector2d SigmasPx() const;
  /// Second moments of the spot if it is a Gaussian: their ratios as above the threshold, their size from the
  /// pixels there.
  Eigen::Matrix2d GaussianShapePx2() const;
  double PeakDn() const { return static_cast<double>(peak_dn_); }
  /// Sum of the brightness above the background.
  double FluxDn() const {
    return static_cast<double>(light_.g) +
           static_cast<double>(ones_.g) * (threshold_dn_ - noise_.background_dn);
  }

 private:
  Eigen::Matrix2d SecondMomentsPx2() const;
  double Cut() const;              ///< threshold / peak, above the background
  double GaussianSizePx2() const;  ///< geometric mean of a Gaussian's second moments

  Eigen::Vector2i origin_px_;
  int threshold_dn_;
  PixelNoise noise_;
  MomentSums light_;  ///< weighted with the brightness above the threshold, DN
  MomentSums ones_;   ///< weighted with 1
  std::uint32_t peak_dn_ = 0;
};

}  // namespace adit::detect
