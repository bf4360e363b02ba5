#include "firmware/detect/centroid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "firmware/detect/stretch_sums.h"

namespace adit::detect {
namespace {

constexpr double kRoundingVarianceDn2 = 1.0 / 12;  // of an analogue-digital converter's last bit
constexpr double kPixelVariancePx2 = 1.0 / 12;     // a pixel is a square, not a point
// What the weight I - T leaves of phase bias and of pixels that noise lifts over the threshold or not (rms
// over the phases): fitted to the errors of simulated spots of sigma 1.2 to 2.2 px and peaks of 50 to 200 DN,
// beyond those of the pixels' noise. It grows as the threshold takes more of the peak, and as spots get
// narrower.
constexpr double kCutOffPx3 = 0.11;  // times threshold / peak / sigma^2

/// The sums, to divide.
struct Moments {
  double g, x, y, xx, xy, yy;

  explicit Moments(const MomentSums& s)
      : g(static_cast<double>(s.g)),
        x(static_cast<double>(s.x)),
        y(static_cast<double>(s.y)),
        xx(static_cast<double>(s.xx)),
        xy(static_cast<double>(s.xy)),
        yy(static_cast<double>(s.yy)) {}
};

/// Sums over pixels of one row.
struct RowSums {
  std::int64_t g = 0, x = 0, xx = 0;
};

/// Adds pixels of the row y whose sums over x are given.
void AddRow(MomentSums& sums, const RowSums& row, std::int64_t y) {
  sums.g += row.g, sums.x += row.x, sums.xx += row.xx;
  sums.y += row.g * y, sums.xy += row.x * y, sums.yy += row.g * y * y;
}

}  // namespace

double PixelNoise::VarianceDn2(double value_dn) const {
  return read_dn * read_dn + (value_dn - background_dn) / electrons_per_dn + kRoundingVarianceDn2;
}

void SpotMoments::Take(const base::ImageView& image, const Run& run) {
  const std::uint8_t* const row = image.Row(run.y_px);
  const bool wide = image.BytesPerPixel() == 2;
  RowSums light;
  std::uint32_t most = 0;
  for (int begin = run.begin_px; begin < run.end_px; begin += kStretchPx) {
    const int count = std::min(kStretchPx, run.end_px - begin);
    const StretchSums s = wide ? SumStretchPlain16(row + std::ptrdiff_t{2} * begin, count, threshold_dn_)
                          : begin + kStretchPx <= image.width_px
                              ? SumStretchWide8(row + begin, count, threshold_dn_)
                              : SumStretchPlain8(row + begin, count, threshold_dn_);
    const std::int64_t x = begin - origin_px_.x(), g = s.g, k = s.k, kk = s.kk;
    light.g += g, light.x += k + x * g, light.xx += kk + 2 * x * k + x * x * g;
    most = std::max(most, s.most);
  }
  const std::int64_t y = run.y_px - origin_px_.y();
  AddRow(light_, light, y);
  // 1, x and x^2 over n pixels from x on.
  const std::int64_t n = run.end_px - run.begin_px, x = run.begin_px - origin_px_.x();
  AddRow(ones_, {n, n * x + n * (n - 1) / 2, n * x * x + n * (n - 1) * x + n * (n - 1) * (2 * n - 1) / 6}, y);
  peak_dn_ = std::max(peak_dn_, most);
}

Eigen::Vector2d SpotMoments::CentroidPx() const {
  const Moments light(light_);
  return origin_px_.cast<double>() + Eigen::Vector2d(light.x, light.y) / light.g;
}

Eigen::Matrix2d SpotMoments::CovariancePx2() const {
  // c = sum g x / sum g, so dc/dI_i = (x_i - c) / sum g. The variance of a pixel is linear in its brightness,
  // so that its sums are those at hand.
  const Moments light(light_), ones(ones_);
  const double cx = light.x / light.g, cy = light.y / light.g;
  const double dimmest_dn2 = noise_.VarianceDn2(threshold_dn_), slope_dn = 1 / noise_.electrons_per_dn;
  const auto sum = [&](double Moments::*of) { return dimmest_dn2 * ones.*of + slope_dn * light.*of; };
  const double v = sum(&Moments::g), vx = sum(&Moments::x), vy = sum(&Moments::y);
  Eigen::Matrix2d covariance;
  covariance(0, 0) = sum(&Moments::xx) - 2 * cx * vx + cx * cx * v;
  covariance(1, 1) = sum(&Moments::yy) - 2 * cy * vy + cy * cy * v;
  covariance(0, 1) = covariance(1, 0) = sum(&Moments::xy) - cx * vy - cy * vx + cx * cy * v;
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
  return static_cast<double>(ones_.g) / (-2 * M_PI * std::log(Cut()));
}

Eigen::Matrix2d SpotMoments::GaussianShapePx2() const {
  const Eigen::Matrix2d seen_px2 = SecondMomentsPx2();
  return seen_px2 * (GaussianSizePx2() / std::sqrt(seen_px2.determinant()));
}

Eigen::Matrix2d SpotMoments::SecondMomentsPx2() const {
  const Moments light(light_);
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
