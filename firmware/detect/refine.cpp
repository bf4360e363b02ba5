#include "firmware/detect/refine.h"

#include <algorithm>
#include <cmath>

#include "firmware/detect/spot_patch.h"
#include "firmware/detect/window_centroid.h"

namespace adit::detect {
namespace {

// Of the spot's sigmas, from its middle to the patch's edge: there it is dark (0.0003 of its height), and
// another spot whose bright part begins there shifts the centroid by less than a tenth of its error.
constexpr double kReachSigmas = 4;
// A spot that reaches further is larger than an LED's image from 10 m on, or smeared over more than 10 px.
constexpr double kLeastReachSigmas = 3;

}  // namespace

std::optional<SpotPlace> Refine(const base::ImageView& image, const SpotMoments& spot, double area_px,
                                int threshold_dn, const PixelNoise& noise) {
  const Eigen::Matrix2d shape_px2 = spot.GaussianShapePx2();
  const Eigen::Vector2d sigmas_px = shape_px2.diagonal().cwiseSqrt();
  if (!(kLeastReachSigmas * sigmas_px.maxCoeff() < SpotPatch::kReachMaxPx)) return std::nullopt;
  SpotPatch patch;
  if (!Load(image, spot.CentroidPx(), kReachSigmas * sigmas_px, threshold_dn, patch)) return std::nullopt;
  if (patch.bright_px != static_cast<int>(area_px)) return std::nullopt;
  const auto first = ThroughWindow(patch, {spot.CentroidPx(), shape_px2, 0});
  if (!first) return std::nullopt;
  const auto second = ThroughWindow(patch, *first);
  if (!second) return std::nullopt;
  return SpotPlace{second->centre_px, CovarianceThroughWindow(*second, noise)};
}

}  // namespace adit::detect
