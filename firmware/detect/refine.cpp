#include "firmware/detect/refine.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
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
// By how much two LEDs must explain the pixels better than one that moved, in chi2: of simulated smears of 3
// to 8 px one in a thousand reaches that. From kDoubt on, which one in thirty reaches, it may be either.
constexpr double kEvidence = 20, kDoubt = 6;
// What of a spot no Gaussian explains, lenses being what they are: of its light, in quadrature.
constexpr double kUnexplained = 0.05;
// Of the way from the threshold to full scale, the mean of a spot's pixels: 0.8 for a Gaussian of ten times
// full scale, near 1 for a lamp.
constexpr double kFlattest = 0.8;
// Where the fit of a clipped spot begins, of full scale.
constexpr double kClippedHeight = 1.5;
// To see enough of another spot 10 px away, and how much brighter than this one it may be.
constexpr double kCompanyReachPx = 13, kLargestCompany = 6;

/// Whether hardly any of the component's pixels is between the threshold and full scale: a lamp, not an LED.
bool IsFlat(const Component& component, const SpotMoments& spot, int threshold_dn,
            const PixelLimits& pixels) {
  const double step_dn = threshold_dn - pixels.noise.background_dn;
  const double mean_dn = spot.FluxDn() / component.area_px - step_dn;
  return mean_dn > kFlattest * (pixels.full_dn - threshold_dn);
}

/// Whether the fit explains the pixels, but for what no Gaussian does.
bool Explains(const SpotFit& fit, double unexplained = kUnexplained) {
  constexpr double kDeviations = 3;  // of chi2, whose variance is twice its mean
  return fit.chi2 <
         fit.freedoms + kDeviations * std::sqrt(2.0 * fit.freedoms) + unexplained * unexplained * fit.energy;
}

/// Its place in the image.
Eigen::Vector2d FirstPixel(const SpotPatch& patch) {
  return {patch.x_px - patch.reach_x_px, patch.y_px - patch.reach_y_px};
}

/// The LEDs of a fit. What it leaves unexplained counts as noise.
LedPlaces PlacesOf(const SpotFit& fit, SpotModel model, const SpotPatch& patch) {
  const double scale = std::max(1.0, fit.chi2 / fit.freedoms);
  const double sigma_px = std::sqrt(fit.parameters[fit.parameters.size() - 2]);
  LedPlaces places;
  for (int i = 0; i < (model == SpotModel::kTwo ? 6 : 3); i += 3)
    places.push_back({FirstPixel(patch) + fit.parameters.segment<2>(i + 1),
                      scale * fit.covariance.block<2, 2>(i + 1, i + 1), fit.parameters[i], sigma_px});
  return places;
}

/// The patch around the component's box.
bool LoadBox(const base::ImageView& image, const Component& c, int threshold_dn, SpotPatch& patch) {
  constexpr double kMarginPx = 3, kLeastMarginPx = 0.5;
  const Eigen::Vector2d box_px(c.x_max_px - c.x_min_px + 1, c.y_max_px - c.y_min_px + 1);
  const Eigen::Vector2d middle_px = Eigen::Vector2d(c.x_min_px + c.x_max_px, c.y_min_px + c.y_max_px) / 2;
  return box_px.maxCoeff() / 2 + kLeastMarginPx < SpotPatch::kReachMaxPx &&
         Load(image, middle_px, box_px / 2 + Eigen::Vector2d::Constant(kMarginPx), threshold_dn, patch);
}

/// The spot beside another bright region near it, fitted together.
LedPlaces InCompany(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                    int threshold_dn, const PixelLimits& pixels) {
  SpotPatch patch;
  const Eigen::Vector2d reach_px = Eigen::Vector2d::Constant(kCompanyReachPx);
  if (!Load(image, spot.CentroidPx(), reach_px, threshold_dn, patch)) return {};
  // The other's moments above the threshold are those of all but the spot's.
  const auto step_dn = static_cast<float>(threshold_dn);
  double light_dn = 0;
  Eigen::Vector2d moment_px_dn = Eigen::Vector2d::Zero();
  for (int y = 0; y < patch.HeightPx(); ++y) {
    for (int x = 0; x < patch.WidthPx(); ++x) {
      const double above_dn = std::max(patch.Row(y)[x] - step_dn, 0.F);
      light_dn += above_dn, moment_px_dn += above_dn * Eigen::Vector2d(x, y);
    }
  }
  const double own_dn = spot.FluxDn() - component.area_px * (threshold_dn - pixels.noise.background_dn);
  const Eigen::Vector2d own_px = spot.CentroidPx() - FirstPixel(patch);
  const double other_dn = light_dn - own_dn;
  if (!(other_dn > 0 && other_dn < kLargestCompany * own_dn)) return {};
  const double height_dn = spot.PeakDn() - patch.background_dn;
  FitVector start(8);
  start << height_dn, own_px, height_dn * std::min(1.0, other_dn / own_dn),
      (moment_px_dn - own_dn * own_px) / other_dn, std::sqrt(spot.GaussianShapePx2().determinant()), 0;
  const auto both = Fit(patch, SpotModel::kTwo, start, pixels);
  if (!both || !Explains(*both)) return {};
  LedPlaces places = PlacesOf(*both, SpotModel::kTwo, patch);
  places.Truncate(1);
  return places;
}

LedPlaces ByWindow(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                   int threshold_dn, const PixelLimits& pixels) {
  const Eigen::Matrix2d shape_px2 = spot.GaussianShapePx2();
  const Eigen::Vector2d sigmas_px = shape_px2.diagonal().cwiseSqrt();
  if (!(kLeastReachSigmas * sigmas_px.maxCoeff() < SpotPatch::kReachMaxPx)) return {};
  SpotPatch patch;
  if (!Load(image, spot.CentroidPx(), kReachSigmas * sigmas_px, threshold_dn, patch)) return {};
  if (patch.bright_px != static_cast<int>(component.area_px))
    return InCompany(image, component, spot, threshold_dn, pixels);
  const auto first = ThroughWindow(patch, {spot.CentroidPx(), shape_px2, 0});
  if (!first) return {};
  const auto second = ThroughWindow(patch, *first);
  if (!second) return {};
  LedPlaces places;
  places.push_back({second->centre_px, CovarianceThroughWindow(*second, pixels.noise), second->height_dn,
                    std::sqrt(std::sqrt(second->shape_px2.determinant()))});
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
  return {spot.CentroidPx() - FirstPixel(patch),
          std::sqrt(2 * half) * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
          spot.PeakDn() - patch.background_dn, size_px2};
}

/// One LED that moved or two at rest, whichever explains the pixels; where both do, one whose covariance has
/// room for either.
LedPlaces Choose(const std::optional<SpotFit>& one, const std::optional<SpotFit>& two, const SpotPatch& patch,
                 int threshold_dn) {
  const bool one_does = one && Explains(*one);
  double evidence = 0;
  Eigen::Vector2d gap_px = Eigen::Vector2d::Zero();
  if (two && Explains(*two)) {
    const FitVector& p = two->parameters;
    gap_px = p.segment<2>(4) - p.segment<2>(1);
    const bool both_bright = std::min(p[0], p[3]) + static_cast<double>(patch.background_dn) > threshold_dn;
    const bool apart = both_bright && gap_px.squaredNorm() > kLeastGapSigmas * kLeastGapSigmas * p[6];
    if (apart) evidence = one_does ? one->chi2 - two->chi2 : kEvidence;
  }
  if (evidence >= kEvidence) return PlacesOf(*two, SpotModel::kTwo, patch);
  if (!one_does) return {};
  LedPlaces places = PlacesOf(*one, SpotModel::kSmeared, patch);
  if (evidence > kDoubt)
    places[0].covariance_px2 +=
        gap_px * gap_px.transpose() / 4 + PlacesOf(*two, SpotModel::kTwo, patch)[0].covariance_px2;
  return places;
}

/// One LED that moved or two at rest.
LedPlaces ByFits(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                 int threshold_dn, const PixelLimits& pixels) {
  SpotPatch patch;
  if (!LoadBox(image, component, threshold_dn, patch) ||
      patch.bright_px != static_cast<int>(component.area_px))
    return {};
  const Start s = StartOf(spot, patch);
  FitVector start(7);
  start << s.height_dn, s.middle_px, std::sqrt(3.0) * 2 * s.half_px, s.size_px2, 0;
  const auto one = Fit(patch, SpotModel::kSmeared, start, pixels);
  start.resize(8);
  start << s.height_dn, s.middle_px - s.half_px, s.height_dn, s.middle_px + s.half_px, s.size_px2, 0;
  const auto two = Fit(patch, SpotModel::kTwo, start, pixels);
  return Choose(one, two, patch, threshold_dn);
}

/// The spot whose middle is clipped, from the pixels that are not.
LedPlaces ByRim(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                int threshold_dn, const PixelLimits& pixels) {
  SpotPatch patch;
  if (!LoadBox(image, component, threshold_dn, patch)) return {};
  if (patch.bright_px != static_cast<int>(component.area_px))
    return InCompany(image, component, spot, threshold_dn, pixels);
  const Start s = StartOf(spot, patch);
  const double height_dn = kClippedHeight * s.height_dn;
  FitVector start(5);
  start << height_dn, s.middle_px, s.size_px2, 0;
  const auto round = Fit(patch, SpotModel::kOne, start, pixels);
  if (round && Explains(*round, 0)) return PlacesOf(*round, SpotModel::kOne, patch);
  start.resize(7);
  start << height_dn, s.middle_px, std::sqrt(3.0) * 2 * s.half_px, s.size_px2, 0;
  const auto smeared = Fit(patch, SpotModel::kSmeared, start, pixels);
  if (smeared && Explains(*smeared) && !(round && round->chi2 < smeared->chi2))
    return PlacesOf(*smeared, SpotModel::kSmeared, patch);
  if (round && Explains(*round)) return PlacesOf(*round, SpotModel::kOne, patch);
  return {};
}

}  // namespace

LedPlaces Refine(const base::ImageView& image, const Component& component, const SpotMoments& spot,
                 int threshold_dn, const PixelLimits& pixels) {
  const Eigen::Vector2d sigmas_px = spot.SigmasPx();
  const bool clipped = spot.PeakDn() >= pixels.full_dn;
  if (clipped && IsFlat(component, spot, threshold_dn, pixels)) return {};
  const auto by = sigmas_px.x() > kRoundestPair * sigmas_px.y() ? ByFits : clipped ? ByRim : ByWindow;
  const LedPlaces places = by(image, component, spot, threshold_dn, pixels);
  const bool all_inside = std::all_of(places.begin(), places.end(), [&](const LedPlace& place) {
    const auto inside = [](double at, int least, int most) { return at >= least && at <= most; };
    return inside(place.centre_px.x(), component.x_min_px, component.x_max_px) &&
           inside(place.centre_px.y(), component.y_min_px, component.y_max_px);
  });
  return all_inside ? places : LedPlaces{};
}

}  // namespace adit::detect
