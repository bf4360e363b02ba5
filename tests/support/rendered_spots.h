// Images of spots whose truth is known, rendered by code of the tests' own: Gaussians integrated over the
// pixels (erf), shot and read noise, rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "firmware/base/image.h"

namespace adit::support {

/// One Gaussian spot, drawn along a straight movement during the exposure. `peak_dn` is the height above the
/// background that its middle has at rest, before clipping.
struct RenderedSpot {
  double x_px = 0, y_px = 0;
  double sigma_px = 1.5;
  double peak_dn = 200;
  double smear_x_px = 0, smear_y_px = 0;  ///< from the movement's begin to its end
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

/// Brightness that the spot gives to the pixel (x, y).
inline double LightDn(const RenderedSpot& spot, double x, double y) {
  const double length_px = std::hypot(spot.smear_x_px, spot.smear_y_px);
  const int steps = length_px == 0 ? 1 : 2 * static_cast<int>(std::ceil(length_px)) + 5;
  double light_dn = 0;
  for (int i = 0; i < steps; ++i) {
    const double part = (i + 0.5) / steps - 0.5;
    light_dn += PixelShare(x, spot.x_px + part * spot.smear_x_px, spot.sigma_px) *
                PixelShare(y, spot.y_px + part * spot.smear_y_px, spot.sigma_px);
  }
  return spot.peak_dn * light_dn / steps;
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

  /// The level of a dark pixel, which has no shot noise, and light that grows along x and y.
  void Background(double level_dn, double slope_x_dn = 0, double slope_y_dn = 0) {
    dark_dn_ = level_dn;
    for (int y = 0; y < height_px_; ++y)
      for (int x = 0; x < width_px_; ++x) Light(x, y) = level_dn + slope_x_dn * x + slope_y_dn * y;
  }
  void Add(const RenderedSpot& spot) {
    const double half_smear_px = std::hypot(spot.smear_x_px, spot.smear_y_px) / 2;
    const int reach = static_cast<int>(std::ceil(6 * spot.sigma_px + half_smear_px)) + 1;
    const int cx = static_cast<int>(std::lround(spot.x_px)), cy = static_cast<int>(std::lround(spot.y_px));
    for (int y = std::max(0, cy - reach); y <= std::min(height_px_ - 1, cy + reach); ++y)
      for (int x = std::max(0, cx - reach); x <= std::min(width_px_ - 1, cx + reach); ++x)
        Light(x, y) += LightDn(spot, x, y);
  }
  /// Light -> pixels. Without noise if `random` is null.
  void Expose(const SensorNoise& noise, std::mt19937* random) {
    std::normal_distribution<double> gauss;
    const double scale = 1 << (bits_ - 8), full_dn = (1 << bits_) - 1;
    for (int y = 0; y < height_px_; ++y) {
      for (int x = 0; x < width_px_; ++x) {
        const double light_dn = Light(x, y);
        const double variance =
            noise.read_dn * noise.read_dn + std::max(0.0, light_dn - dark_dn_) / noise.electrons_per_dn;
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
  double dark_dn_ = 0;
};

}  // namespace adit::support
