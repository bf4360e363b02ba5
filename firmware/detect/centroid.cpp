#include "firmware/detect/centroid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace adit::detect {
namespace {

constexpr double kRoundingVarianceDn2 = 1.0 / 12;  // of an analogue-digital converter's last bit
constexpr double kPixelVariancePx2 = 1.0 / 12;     // a pixel is a square, not a point
// What the weight I - T leaves of phase bias and of pixels that noise lifts over the threshold or not (rms
// over the phases): fitted to the errors of simulated spots of sigma 1.2 to 2.2 px and peaks of 50 to 200 DN,
// beyond those of the pixels' noise. It grows as the threshold takes more of the peak, and as spots get
// narrower.
constexpr double kCutOffPx3 = 0.11;  // times threshold / peak / sigma^2

}  // namespace

double PixelNoise::VarianceDn2(double value_dn) const {
  return read_dn * read_dn + (value_dn - background_dn) / electrons_per_dn + kRoundingVarianceDn2;
}

Eigen::Vector2d SpotMoments::CentroidPx() const {
  const MomentSums& light = sums_.light;
  return origin_px_.cast<double>() + Eigen::Vector2d(light.x, light.y) / light.g;
}

Eigen::Matrix2d SpotMoments::CovariancePx2() const {
  // c = sum g x / sum g, so dc/dI_i = (x_i - c) / sum g. The variance of a pixel is linear in its brightness,
  // so that its sums are those at hand.
  const MomentSums &light = sums_.light, &ones = sums_.ones;
  const double cx = light.x / light.g, cy = light.y / light.g;
  const double dimmest_dn2 = noise_.VarianceDn2(threshold_dn_), slope_dn = 1 / noise_.electrons_per_dn;
  const auto sum = [&](double MomentSums::*of) { return dimmest_dn2 * ones.*of + slope_dn * light.*of; };
  const double v = sum(&MomentSums::g), vx = sum(&MomentSums::x), vy = sum(&MomentSums::y);
  Eigen::Matrix2d covariance;
  covariance(0, 0) = sum(&MomentSums::xx) - 2 * cx * vx + cx * cx * v;
  covariance(1, 1) = sum(&MomentSums::yy) - 2 * cy * vy + cy * cy * v;
  covariance(0, 1) = covariance(1, 0) = sum(&MomentSums::xy) - cx * vy - cy * vx + cx * cy * v;
  covariance /= light.g * light.g;
  const double bias_px = kCutOffPx3 * Cut() / std::max(GaussianSizePx2(), 1.0);
  return covariance + bias_px * bias_px * Eigen::Matrix2d::Identity();
}

double SpotMoments::Cut() const {
  const double height_dn = std::max(1.0, PeakDn() - noise_.background_dn);
  return std::clamp((threshold_dn_ - noise_.background_dn) / height_dn, 0.01, 0.9);
}

double SpotMoments::GaussianSizePx2() const {
  // A Gaussian of height h, cut off at t, covers 2 pi sigma^2 ln(h / t).
  return sums_.ones.g / (-2 * M_PI * std::log(Cut()));
}

Eigen::Matrix2d SpotMoments::GaussianShapePx2() const {
  const Eigen::Matrix2d seen_px2 = SecondMomentsPx2();
  return seen_px2 * (GaussianSizePx2() / std::sqrt(seen_px2.determinant()));
}

Eigen::Matrix2d SpotMoments::SecondMomentsPx2() const {
  const MomentSums& light = sums_.light;
  const double cx = light.x / light.g, cy = light.y / light.g;
  Eigen::Matrix2d moments_px2;
  moments_px2(0, 0) = light.xx / light.g - cx * cx + kPixelVariancePx2;
  moments_px2(0, 1) = moments_px2(1, 0) = light.xy / light.g - cx * cy;
  moments_px2(1, 1) = light.yy / light.g - cy * cy + kPixelVariancePx2;
  return moments_px2;
}

Eigen::Vector2d SpotMoments::SigmasPx() const {
  const Eigen::Matrix2d m = SecondMomentsPx2();
  const double middle = m.trace() / 2, apart = (m(0, 0) - m(1, 1)) / 2;
  const double half = std::sqrt(apart * apart + m(0, 1) * m(0, 1));
  return {std::sqrt(middle + half), std::sqrt(std::max(middle - half, 0.0))};
}

}  // namespace adit::detect
