// The luminance-weighted centroid of one bright spot and how well it is known.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "firmware/base/image.h"
#include "firmware/detect/row_scan.h"

namespace adit::detect {

/// Pixel noise, in DN of the image's own bits.
struct PixelNoise {
  double read_dn = 0;
  double electrons_per_dn = 0;
  double background_dn = 0;

  /// Variance of a pixel of that brightness: read noise, shot noise, rounding.
  double VarianceDn2(double value_dn) const;
};

/// Moments of a component weighted with the brightness above the threshold. Take every run of the component
/// once, in any order; then ask.
class SpotMoments {
 public:
  /// Sums are taken about `origin_px`, near the spot, so that they stay small.
  SpotMoments(const Eigen::Vector2d& origin_px, double threshold_dn, const PixelNoise& noise)
      : origin_px_(origin_px), threshold_dn_(threshold_dn), noise_(noise) {}

  void Take(const base::ImageView& image, const Run& run);

  Eigen::Vector2d CentroidPx() const;
  /// Of the centroid: the pixels' noise through the weights, and what the cut-off at the threshold leaves.
  Eigen::Matrix2d CovariancePx2() const;
  /// Square roots of the eigenvalues of the second moments, larger first.
  Eigen::Vector2d SigmasPx() const;
  double PeakDn() const { return peak_dn_; }
  /// Sum of the brightness above the background.
  double FluxDn() const { return flux_dn_; }

 private:
  Eigen::Vector2d origin_px_;
  double threshold_dn_;
  PixelNoise noise_;
  double weight_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0;
  // Variance-weighted sums, for the covariance.
  double v_ = 0, vx_ = 0, vy_ = 0, vxx_ = 0, vxy_ = 0, vyy_ = 0;
  double peak_dn_ = 0, flux_dn_ = 0, area_px_ = 0;
};

}  // namespace adit::detect
