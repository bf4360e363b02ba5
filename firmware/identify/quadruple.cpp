#include "firmware/identify/quadruple.h"

#include <algorithm>
#include <cmath>

namespace adit::identify {

QuadrupleTest::QuadrupleTest(const Model& model, const IdentifierOptions& options)
    : model_(model), options_(options), cross_ratio_(CrossRatio(model.target.leds_m)) {
  const auto lever = [&model](std::size_t i) {
    return model.target.leds_m[i] * (model.target.LengthM() - model.target.leds_m[i]);
  };
  middle_ = lever(1) > lever(2) ? 1 : 2;
}

double QuadrupleTest::PerspectiveMax(double length_px) const {
  if (!(options_.focal_px > 0)) return options_.perspective_max;
  // With k = dz / Z and image length l = f L cos(tilt) / Z: (f k)^2 + l^2 = (f L / Z)^2, and the trained
  // range says that f L / Z is never above its longest image. Off the axis the ray meets the bar obliquely,
  // which the factor covers up to 30 degrees of half field.
  constexpr double kOffAxis = 1.25;
  const double longest_px = kOffAxis * model_.length_max_px;
  const double k =
      std::sqrt(std::max(0.0, longest_px * longest_px - length_px * length_px)) / options_.focal_px;
  return std::min(options_.perspective_max, k);
}

std::optional<Sighting> QuadrupleTest::Judge(const BlobGrid& grid, const Quadruple& leds) const {
  const Eigen::Vector2d first = grid.Place(leds[0]);
  const Eigen::Vector2d span = grid.Place(leds[3]) - first;
  const double length_px = span.norm();
  if (!(length_px >= model_.length_min_px && length_px <= model_.length_max_px)) return std::nullopt;
  const Eigen::Vector2d along = span / length_px;
  const Eigen::Vector2d across(-along.y(), along.x());
  LinePlaces t, off, sigma;
  const double floor_px2 = options_.centroid_floor_px * options_.centroid_floor_px;
  for (std::size_t i = 0; i < leds.size(); ++i) {
    const Eigen::Vector2d place = grid.Place(leds[i]) - first;
    t[i] = along.dot(place), off[i] = across.dot(place);
    sigma[i] = std::sqrt(grid.Variance(leds[i]) + floor_px2);
  }
  if (!(t[0] < t[1] && t[1] < t[2] && t[2] < t[3])) return std::nullopt;
  if (!Collinear(t, off, sigma) || !HasCrossRatio(t, sigma) || !HasPerspective(t, sigma)) return std::nullopt;
  Sighting sighting;
  for (std::size_t i = 0; i < leds.size(); ++i) sighting.blobs[i] = grid.Index(leds[i]);
  sighting.p2 = static_cast<float>(P2(CrossRatio(t)));
  sighting.collinearity_px = static_cast<float>(RmsFromLine(t, off));
  sighting.length_px = static_cast<float>(length_px);
  return sighting;
}

bool QuadrupleTest::Collinear(const LinePlaces& along_px, const LinePlaces& across_px,
                              const LinePlaces& sigma_px) const {
  // The trained law, and what the noise of these four centroids allows: the tighter one decides.
  if (!(RmsFromLine(along_px, across_px) <= model_.collinearity_max * along_px[3])) return false;
  for (const std::size_t i : {1UL, 2UL}) {
    const double r = along_px[i] / along_px[3];
    const double variance = sigma_px[i] * sigma_px[i] + (1 - r) * (1 - r) * sigma_px[0] * sigma_px[0] +
                            r * r * sigma_px[3] * sigma_px[3];
    if (!(std::abs(across_px[i]) <= options_.sigmas * std::sqrt(variance))) return false;
  }
  return true;
}

bool QuadrupleTest::HasCrossRatio(const LinePlaces& along_px, const LinePlaces& sigma_px) const {
  const double ratio = CrossRatio(along_px);
  const double p2 = P2(ratio);
  if (!(p2 >= model_.p2_min && p2 <= model_.p2_max)) return false;
  // J alone is blind to lambda -> 1 - lambda, and flat at 1/2; the order on the line is known here, so that
  // lambda itself is tested against the target as built.
  const LinePlaces slopes = CrossRatioSlopes(along_px);
  double variance = 0;
  for (std::size_t i = 0; i < slopes.size(); ++i)
    variance += slopes[i] * slopes[i] * sigma_px[i] * sigma_px[i];
  return std::abs(ratio - cross_ratio_) <= options_.sigmas * std::sqrt(variance);
}

bool QuadrupleTest::HasPerspective(const LinePlaces& along_px, const LinePlaces& sigma_px) const {
  // t_i / t_4 = (s_i / s_4) (1 + c s_4) / (1 + c s_i), solved for k = c s_4.
  const double r = model_.target.leds_m[middle_] / model_.target.LengthM();
  const double q = along_px[middle_] / along_px[3] / r;
  const double k = (1 - q) / (q * r - 1);
  const double q_sigma = (sigma_px[middle_] + r * sigma_px[3] + (1 - r) * sigma_px[0]) / (along_px[3] * r);
  const double k_sigma = q_sigma * (1 - r) / ((q * r - 1) * (q * r - 1));
  return std::abs(k) <= PerspectiveMax(along_px[3]) + options_.sigmas * k_sigma;
}

double QuadrupleTest::RmsFromLine(const LinePlaces& along_px, const LinePlaces& across_px) const {
  double mean_t = 0, mean_off = 0;
  for (std::size_t i = 0; i < 4; ++i) mean_t += along_px[i] / 4, mean_off += across_px[i] / 4;
  double tt = 0, to = 0, oo = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double t = along_px[i] - mean_t, off = across_px[i] - mean_off;
    tt += t * t, to += t * off, oo += off * off;
  }
  // Smaller eigenvalue of the scatter: the moment matrix of the seed, 4.3.4.2.
  const double half_sum = 0.5 * (tt + oo), half_difference = 0.5 * (tt - oo);
  const double smaller = half_sum - std::sqrt(half_difference * half_difference + to * to);
  return std::sqrt(std::max(0.0, smaller) / 4);
}

}  // namespace adit::identify
