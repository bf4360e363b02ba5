#include "firmware/detect/window_centroid.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstring>

#include "firmware/detect/lanes.h"

namespace adit::detect {
namespace {

/// Light times window, summed up with the place from the window's middle.
struct WindowSums {
  double g = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// The window is exp(-(p dx^2 + 2 q dx dy + r dy^2) / 2). Its factor of dx and dy both is a geometric series
/// down every column.
struct WindowShape {
  float p, q, r;
  float x_px, y_px;  ///< its middle, from the patch's first pixel
};

template <int kVectors>
ADIT_INLINE WindowSums SumUp(const SpotPatch& patch, const WindowShape& w) {
  constexpr std::size_t kCount = kVectors;
  const int rows = patch.HeightPx();
  const Floats end = Floats{} + static_cast<float>(patch.WidthPx());
  FloatsRow down;
  std::array<Floats, kCount> dx, weight, ratio, g, gy, gyy;
  g.fill(Floats{}), gy.fill(Floats{}), gyy.fill(Floats{});
  for (std::size_t v = 0; v < kCount; ++v) {
    const Floats place = kLaneIndex + static_cast<float>(v * kFloatLanes);
    const Floats inside = place < end ? place : end;  // beyond the edge the weight is 0
    dx[v] = inside - w.x_px;
    weight[v] = (-0.5F * w.p * dx[v] + w.q * w.y_px) * dx[v];
    ratio[v] = -w.q * dx[v];
    Exp(weight[v]), Exp(ratio[v]);
    weight[v] = place < end ? weight[v] : Floats{};
  }
  for (std::size_t v = 0; kFloatLanes * static_cast<int>(v) < rows; ++v) {
    const Floats dy = kLaneIndex + (static_cast<float>(v * kFloatLanes) - w.y_px);
    down[v] = -0.5F * w.r * dy * dy;
    Exp(down[v]);
  }
  for (int row = 0; row < rows; ++row) {
    const float dy = static_cast<float>(row) - w.y_px;
    const float* const values = patch.Row(row);
    const float factor = down[static_cast<std::size_t>(row / kFloatLanes)][row % kFloatLanes];
    for (std::size_t v = 0; v < kCount; ++v) {
      Floats pixels;
      std::memcpy(&pixels, values + v * kFloatLanes, sizeof(pixels));
      const Floats product = (pixels - patch.background_dn) * (weight[v] * factor), first = product * dy;
      g[v] += product, gy[v] += first, gyy[v] += first * dy;
      weight[v] *= ratio[v];
    }
  }
  WindowSums sums;
  for (std::size_t v = 0; v < kCount; ++v) {
    const Floats gx = g[v] * dx[v];
    sums.g += SumLanes(g[v]), sums.x += SumLanes(gx), sums.y += SumLanes(gy[v]);
    sums.xx += SumLanes(gx * dx[v]), sums.xy += SumLanes(gy[v] * dx[v]), sums.yy += SumLanes(gyy[v]);
  }
  return sums;
}

template <int kVectors>
WindowSums SumUpBaseline(const SpotPatch& patch, const WindowShape& w) {
  return SumUp<kVectors>(patch, w);
}
template <int kVectors>
ADIT_AVX2 WindowSums SumUpAvx2(const SpotPatch& patch, const WindowShape& w) {
  return SumUp<kVectors>(patch, w);
}

WindowSums SumUpFastest(const SpotPatch& patch, const WindowShape& w) {
  using Sums = WindowSums (*)(const SpotPatch&, const WindowShape&);
  static constexpr std::array<Sums, kRowVectors> kBaseline{SumUpBaseline<1>, SumUpBaseline<2>,
                                                           SumUpBaseline<3>, SumUpBaseline<4>};
  static constexpr std::array<Sums, kRowVectors> kAvx2{SumUpAvx2<1>, SumUpAvx2<2>, SumUpAvx2<3>,
                                                       SumUpAvx2<4>};
  return (HasAvx2() ? kAvx2 : kBaseline)[static_cast<std::size_t>(patch.vectors - 1)](patch, w);
}

}  // namespace

std::optional<GaussianSpot> ThroughWindow(const SpotPatch& patch, const GaussianSpot& start) {
  const Eigen::Matrix2d inverse = start.shape_px2.inverse();
  const Eigen::Vector2d first_px(patch.x_px - patch.reach_x_px, patch.y_px - patch.reach_y_px);
  const Eigen::Vector2f middle_px = (start.centre_px - first_px).cast<float>();
  // exp(89) is too much for a float.
  constexpr double kMostExponent = 80;
  if (!(inverse(0, 0) * patch.reach_x_px * patch.reach_x_px < 2 * kMostExponent &&
        inverse(1, 1) * patch.reach_y_px * patch.reach_y_px < 2 * kMostExponent))
    return std::nullopt;
  const WindowSums s =
      SumUpFastest(patch, {static_cast<float>(inverse(0, 0)), static_cast<float>(inverse(0, 1)),
                           static_cast<float>(inverse(1, 1)), middle_px.x(), middle_px.y()});
  if (!(s.g > 0)) return std::nullopt;
  const Eigen::Vector2d mean(s.x / s.g, s.y / s.g);
  Eigen::Matrix2d product;
  product << s.xx / s.g, s.xy / s.g, s.xy / s.g, s.yy / s.g;
  product -= mean * mean.transpose();
  // product^-1 = window^-1 + spot^-1 and product^-1 mean = spot^-1 (centre - window's).
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - product * inverse;
  // With both of one shape the rest is 1/2: a quarter of its determinant.
  constexpr double kLeast = 1.0 / 16, kMost = 9.0 / 16;
  const double determinant = rest.determinant();
  if (!(determinant > kLeast && determinant < kMost && rest.trace() > 0)) return std::nullopt;
  const Eigen::Matrix2d widen = rest.inverse();
  GaussianSpot spot;
  spot.centre_px = first_px + middle_px.cast<double>() + widen * mean;
  spot.shape_px2 = widen * product;
  spot.shape_px2(1, 0) = spot.shape_px2(0, 1);
  // The window's height is 1: that of the product is the spot's, but for the distance of the two.
  spot.height_dn = s.g / (2 * M_PI * std::sqrt(product.determinant()));
  if (!(spot.shape_px2.determinant() > 0 && spot.shape_px2(0, 0) > 0)) return std::nullopt;
  return spot;
}

Eigen::Matrix2d CovarianceThroughWindow(const GaussianSpot& spot, const PixelNoise& noise) {
  // In units of the spot's sigmas: the variance of sum g u (I - b) over (pi / 2 times height)^2, the slope of
  // its mean; g^2 and g^3 are Gaussians again.
  const double h = spot.height_dn, dark_dn2 = noise.VarianceDn2(noise.background_dn);
  const double even = 2 * dark_dn2 / (M_PI * h * h), shot = 8 / (9 * M_PI * h * noise.electrons_per_dn);
  return spot.shape_px2 * ((even + shot) / std::sqrt(spot.shape_px2.determinant()));
}

}  // namespace adit::detect
