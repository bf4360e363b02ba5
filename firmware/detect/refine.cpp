#include "firmware/detect/refine.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/detect/spot_patch.h"
#include "firmware/detect/window_centroid.h"

namespace adit::detect {
namespace {

// Of the spot's sigmas, from its middle to the patch's edge: there it is dark (0.0003 of its height), and
// another spot whose bright part begins there shifts the centroid by less than a tenth of its error.
constexpr double kReachSigmas = 4;
// A spot that reaches further is larger than an LED's image from 10 m on, or smeared over more than 10 px.
constexpr double kLeastReachSigmas = 3;
// Two LEDs a gap g apart are longer than wide by sqrt(1 + g^2 / 4 sigma^2): what is rounder than this has no
// two that could be told apart.
constexpr double kRoundestPair = 1.2;
constexpr double kLeastGapSigmas = 1.4;
// By how much two LEDs must explain the pixels better than one that moved: e^8 to one.
constexpr double kEvidence = 16;
// What of a spot no Gaussian explains, lenses being what they are: of its light, in quadrature.
constexpr double kUnexplained = 0.05;

LedPlaces ByWindow(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                   int threshold_dn, const PixelNoise& noise) {
  const Eigen::Matrix2d shape_px2 = spot.GaussianShapePx2();
  const Eigen::Vector2d sigmas_px = shape_px2.diagonal().cwiseSqrt();
  if (!(kLeastReachSigmas * sigmas_px.maxCoeff() < SpotPatch::kReachMaxPx)) return {};
  SpotPatch patch;
  if (!Load(image, spot.CentroidPx(), kReachSigmas * sigmas_px, threshold_dn, patch)) return {};
  if (patch.bright_px != static_cast<int>(component.area_px)) return {};
  const auto first = ThroughWindow(patch, {spot.CentroidPx(), shape_px2, 0});
  if (!first) return {};
  const auto second = ThroughWindow(patch, *first);
  if (!second) return {};
  LedPlaces places;
  places.push_back({second->centre_px, CovarianceThroughWindow(*second, noise), second->height_dn,
                    std::sqrt(std::sqrt(second->shape_px2.determinant()))});
  return places;
}

/// Whether the fit explains the pixels, but for what no Gaussian does.
bool Explains(const SpotFit& fit) {
  constexpr double kDeviations = 5;  // of chi2, whose variance is twice its mean
  return fit.chi2 < fit.freedoms + kDeviations * std::sqrt(2.0 * fit.freedoms) +
                        kUnexplained * kUnexplained * fit.energy;
}

/// The LEDs of a fit. What it leaves unexplained counts as noise.
LedPlaces PlacesOf(const SpotFit& fit, SpotModel model, const SpotPatch& patch) {
  const Eigen::Vector2d first_px(patch.x_px - patch.reach_x_px, patch.y_px - patch.reach_y_px);
  const double scale = std::max(1.0, fit.chi2 / fit.freedoms);
  const double sigma_px = std::sqrt(fit.parameters[fit.parameters.size() - 2]);
  LedPlaces places;
  for (int i = 0; i < (model == SpotModel::kTwo ? 6 : 3); i += 3)
    places.push_back({first_px + fit.parameters.segment<2>(i + 1),
                      scale * fit.covariance.block<2, 2>(i + 1, i + 1), fit.parameters[i], sigma_px});
  return places;
}

/// Where the fits of a long spot begin.
struct Start {
  Eigen::Vector2d middle_px,
      half_px;  ///< from the patch's first pixel; to where the end's light would be, if it were in two points
  double height_dn, size_px2;
};

Start StartOf(const SpotMoments& spot, const SpotPatch& patch) {
  const Eigen::Matrix2d shape_px2 = spot.GaussianShapePx2();
  const double middle = shape_px2.trace() / 2, off = shape_px2(0, 1);
  const double half = std::hypot((shape_px2(0, 0) - shape_px2(1, 1)) / 2, off);
  const double size_px2 = std::max(middle - half, 0.5);
  const double angle = std::atan2(off, (shape_px2(0, 0) - shape_px2(1, 1)) / 2) / 2;
  const Eigen::Vector2d first_px(patch.x_px - patch.reach_x_px, patch.y_px - patch.reach_y_px);
  return {spot.CentroidPx() - first_px,
          std::sqrt(2 * half) * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
          spot.PeakDn() - patch.background_dn, size_px2};
}

/// One LED that moved or two at rest, whichever explains the pixels.
LedPlaces ByFits(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                 int threshold_dn, const PixelLimits& pixels) {
  const Component& c = component;
  const Eigen::Vector2d box_px(c.x_max_px - c.x_min_px + 1, c.y_max_px - c.y_min_px + 1);
  const Eigen::Vector2d middle_px = Eigen::Vector2d(c.x_min_px + c.x_max_px, c.y_min_px + c.y_max_px) / 2;
  constexpr double kMarginPx = 3, kLeastMarginPx = 1.5;
  if (!(box_px.maxCoeff() / 2 + kLeastMarginPx < SpotPatch::kReachMaxPx)) return {};
  SpotPatch patch;
  if (!Load(image, middle_px, box_px / 2 + Eigen::Vector2d::Constant(kMarginPx), threshold_dn, patch))
    return {};
  if (patch.bright_px != static_cast<int>(c.area_px)) return {};
  const Start s = StartOf(spot, patch);
  FitVector start(7);
  start << s.height_dn, s.middle_px, std::sqrt(3.0) * 2 * s.half_px, s.size_px2, 0;
  const auto one = Fit(patch, SpotModel::kSmeared, start, pixels);
  start.resize(8);
  start << s.height_dn, s.middle_px - s.half_px, s.height_dn, s.middle_px + s.half_px, s.size_px2, 0;
  const auto two = Fit(patch, SpotModel::kTwo, start, pixels);
  const bool one_does = one && Explains(*one), two_do = two && Explains(*two);
  const auto& p = two->parameters;
  const bool apart =
      two_do && (p.segment<2>(1) - p.segment<2>(4)).squaredNorm() > kLeastGapSigmas * kLeastGapSigmas * p[6];
  if (apart && (!one_does || one->chi2 - two->chi2 > kEvidence))
    return PlacesOf(*two, SpotModel::kTwo, patch);
  if (one_does) return PlacesOf(*one, SpotModel::kSmeared, patch);
  return {};
}

}  // namespace

LedPlaces Refine(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                 int threshold_dn, const PixelLimits& pixels) {
  const Eigen::Vector2d sigmas_px = spot.SigmasPx();
  const bool saturated = spot.PeakDn() >= pixels.full_dn,
             may_be_two = sigmas_px.x() > kRoundestPair * sigmas_px.y();
  if (!saturated && !may_be_two) return ByWindow(image, component, spot, threshold_dn, pixels.noise);
  if (may_be_two) return ByFits(image, component, spot, threshold_dn, pixels);
  return {};
}

}  // namespace adit::detect
