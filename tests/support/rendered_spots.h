// Images of spots whose truth is known, rendered by code of the tests' own: Gaussians integrated over the
// pixels (erf), shot and read noise, rounding. And what no estimator can beat on them.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "firmware/base/image.h"

namespace adit::support {

/// One Gaussian spot. `peak_dn` is the height above the background of its middle, before clipping.
struct RenderedSpot {
  double x_px = 0, y_px = 0;
  double sigma_px = 1.5;
  double peak_dn = 200;
};

/// The sensor's noise, in DN of 8 bit.
struct SensorNoise {
  double read_dn = 1.5;
  double electrons_per_dn = 40;
};

/// Part of a unit Gaussian's integral over the pixel `i`, as brightness of a spot with peak 1.
inline double PixelShare(double i, double centre_px, double sigma_px) {
  const double root = sigma_px * std::sqrt(2.0);
  const double integral =
      0.5 * (std::erf((i + 0.5 - centre_px) / root) - std::erf((i - 0.5 - centre_px) / root));
  return integral * std::sqrt(2 * M_PI) * sigma_px;
}

/// A grey image in memory of its own; `padding_bytes` follow each row.
class RenderedImage {
 public:
  RenderedImage(int width_px, int height_px, int bits = 8, int padding_bytes = 0)
      : width_px_(width_px), height_px_(height_px), bits_(bits) {
    stride_bytes_ =
        static_cast<std::size_t>(width_px) * (bits > 8 ? 2 : 1) + static_cast<std::size_t>(padding_bytes);
    bytes_.assign(stride_bytes_ * static_cast<std::size_t>(height_px), 0xEE);
    light_dn_.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), 0);
  }

  void Background(double level_dn, double slope_x_dn = 0, double slope_y_dn = 0) {
    for (int y = 0; y < height_px_; ++y)
      for (int x = 0; x < width_px_; ++x) Light(x, y) = level_dn + slope_x_dn * x + slope_y_dn * y;
  }
  void Add(const RenderedSpot& spot) {
    const int reach = static_cast<int>(std::ceil(6 * spot.sigma_px)) + 1;
    const int cx = static_cast<int>(std::lround(spot.x_px)), cy = static_cast<int>(std::lround(spot.y_px));
    for (int y = std::max(0, cy - reach); y <= std::min(height_px_ - 1, cy + reach); ++y)
      for (int x = std::max(0, cx - reach); x <= std::min(width_px_ - 1, cx + reach); ++x)
        Light(x, y) +=
            spot.peak_dn * PixelShare(x, spot.x_px, spot.sigma_px) * PixelShare(y, spot.y_px, spot.sigma_px);
  }
  /// Light -> pixels. Without noise if `random` is null.
  void Expose(const SensorNoise& noise, std::mt19937* random) {
    std::normal_distribution<double> gauss;
    const double scale = 1 << (bits_ - 8), full_dn = (1 << bits_) - 1;
    for (int y = 0; y < height_px_; ++y) {
      for (int x = 0; x < width_px_; ++x) {
        const double light_dn = Light(x, y);
        const double variance =
            noise.read_dn * noise.read_dn + std::max(0.0, light_dn) / noise.electrons_per_dn;
        const double value = light_dn + (random != nullptr ? std::sqrt(variance) * gauss(*random) : 0);
        Put(x, y, std::clamp(std::round(value * scale), 0.0, full_dn));
      }
    }
  }
  base::ImageView View() const {
    return {bytes_.data(), width_px_, height_px_, static_cast<std::ptrdiff_t>(stride_bytes_), bits_};
  }
  base::CameraFrame Frame() const {
    base::CameraFrame frame;
    frame.image = View();
    return frame;
  }

 private:
  double& Light(int x, int y) { return light_dn_[static_cast<std::size_t>(y * width_px_ + x)]; }
  void Put(int x, int y, double value) {
    std::uint8_t* const row = bytes_.data() + static_cast<std::size_t>(y) * stride_bytes_;
    if (bits_ == 8) {
      row[x] = static_cast<std::uint8_t>(value);
    } else {
      row[2 * x] = static_cast<std::uint8_t>(static_cast<unsigned>(value) & 0xFF);
      row[2 * x + 1] = static_cast<std::uint8_t>(static_cast<unsigned>(value) >> 8);
    }
  }

  int width_px_, height_px_, bits_;
  std::size_t stride_bytes_ = 0;
  std::vector<std::uint8_t> bytes_;
  std::vector<double> light_dn_;
};

/// The Cramer-Rao bound of the spot's x (px): peak, place and background unknown, clipped pixels without
/// information.
inline double CramerRaoXPx(const RenderedSpot& spot, double background_dn, const SensorNoise& noise,
                           double full_dn = 255) {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  const int reach = static_cast<int>(std::ceil(5 * spot.sigma_px));
  constexpr double kStepPx = 1e-4;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const double fx = spot.x_px - std::floor(spot.x_px), fy = spot.y_px - std::floor(spot.y_px);
      const double gx = PixelShare(x, fx, spot.sigma_px), gy = PixelShare(y, fy, spot.sigma_px);
      const double light = background_dn + spot.peak_dn * gx * gy;
      if (light > full_dn) continue;
      const double dx =
          (PixelShare(x, fx + kStepPx, spot.sigma_px) - PixelShare(x, fx - kStepPx, spot.sigma_px)) /
          (2 * kStepPx);
      const double dy =
          (PixelShare(y, fy + kStepPx, spot.sigma_px) - PixelShare(y, fy - kStepPx, spot.sigma_px)) /
          (2 * kStepPx);
      const Eigen::Vector4d slope(spot.peak_dn * dx * gy, spot.peak_dn * gx * dy, gx * gy, 1);
      const double variance = noise.read_dn * noise.read_dn + light / noise.electrons_per_dn + 1.0 / 12;
      information += slope * slope.transpose() / variance;
    }
  }
  return std::sqrt(information.inverse()(0, 0));
}

}  // namespace adit::support
