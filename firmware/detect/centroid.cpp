#include "firmware/detect/centroid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

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
  return read_dn * read_dn + std::max(0.0, value_dn - background_dn) / electrons_per_dn +
         kRoundingVarianceDn2;
}

void SpotMoments::Take(const base::ImageView& image, const Run& run) {
  const std::uint8_t* const row = image.Row(run.y_px);
  const double y = run.y_px - origin_px_.y();
  area_px_ += run.end_px - run.begin_px;
  for (int i = run.begin_px; i < run.end_px; ++i) {
    std::uint16_t value = row[i];
    if (image.BytesPerPixel() == 2) std::memcpy(&value, row + 2 * i, sizeof(value));
    const double x = i - origin_px_.x();
    const double w = value - threshold_dn_;
    const double v = noise_.VarianceDn2(value);
    weight_ += w, x_ += w * x, y_ += w * y;
    xx_ += w * x * x, xy_ += w * x * y, yy_ += w * y * y;
    v_ += v, vx_ += v * x, vy_ += v * y;
    vxx_ += v * x * x, vxy_ += v * x * y, vyy_ += v * y * y;
    flux_dn_ += value - noise_.background_dn;
    peak_dn_ = std::max<double>(peak_dn_, value);
  }
}

Eigen::Vector2d SpotMoments::CentroidPx() const { return origin_px_ + Eigen::Vector2d(x_, y_) / weight_; }

Eigen::Matrix2d SpotMoments::CovariancePx2() const {
  // c = sum w x / sum w, so dc/dI_i = (x_i - c) / sum w.
  const double cx = x_ / weight_, cy = y_ / weight_;
  Eigen::Matrix2d covariance;
  covariance(0, 0) = vxx_ - 2 * cx * vx_ + cx * cx * v_;
  covariance(1, 1) = vyy_ - 2 * cy * vy_ + cy * cy * v_;
  covariance(0, 1) = covariance(1, 0) = vxy_ - cx * vy_ - cy * vx_ + cx * cy * v_;
  covariance /= weight_ * weight_;
  // A Gaussian of height h, cut off at t, covers 2 pi sigma^2 ln(h / t).
  const double height_dn = std::max(1.0, peak_dn_ - noise_.background_dn);
  const double cut = std::clamp((threshold_dn_ - noise_.background_dn) / height_dn, 0.01, 0.9);
  const double sigma_px2 = area_px_ / (-2 * M_PI * std::log(cut));
  const double bias_px = kCutOffPx3 * cut / std::max(sigma_px2, 1.0);
  return covariance + bias_px * bias_px * Eigen::Matrix2d::Identity();
}

Eigen::Vector2d SpotMoments::SigmasPx() const {
  const double cx = x_ / weight_, cy = y_ / weight_;
  const double a = xx_ / weight_ - cx * cx + kPixelVariancePx2;
  const double b = xy_ / weight_ - cx * cy;
  const double d = yy_ / weight_ - cy * cy + kPixelVariancePx2;
  const double middle = (a + d) / 2, half = std::hypot((a - d) / 2, b);
  return {std::sqrt(middle + half), std::sqrt(std::max(middle - half, 0.0))};
}

}  // namespace adit::detect
