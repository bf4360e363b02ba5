#include "firmware/identify/quadruple_search.h"

#include <algorithm>
#include <cmath>

namespace adit::identify {

using Eigen::Vector2d;

struct QuadrupleSearch::Base {
  const BlobGrid* grid;
  std::uint8_t target;
  long* budget;
  std::size_t first, second;  ///< grid places of LED base_ and the next
  Vector2d origin_px, along;
  double gap_px;
  double perspective_max;
};

QuadrupleSearch::QuadrupleSearch(const Model& model, const IdentifierOptions& options)
    : test_(model, options) {
  const auto& leds_m = model.target.leds_m;
  // A short base has few pairs of blobs to look at; one much shorter than the bar says too little about where
  // the rest is. An eighth: the noise of the base grows at most eightfold at the far end.
  constexpr double kShortestShare = 0.125;
  gap_m_ = model.target.LengthM();
  for (std::size_t i = 0; i + 1 < leds_m.size(); ++i) {
    const double gap_m = leds_m[i + 1] - leds_m[i];
    if (gap_m >= kShortestShare * model.target.LengthM() && gap_m < gap_m_) gap_m_ = gap_m, base_ = i;
  }
  // The LED farthest from the base fixes the perspective; an end always.
  const auto distance = [&](std::size_t i) {
    return std::max(leds_m[base_] - leds_m[i], leds_m[i] - leds_m[base_ + 1]);
  };
  far_ = distance(0) > distance(3) ? 0 : 3;
  for (std::size_t i = 0; i < leds_m.size(); ++i) {
    if (i != base_ && i != base_ + 1 && i != far_) rest_ = i;
  }
  // The gap's share of the image's length changes by the perspective, at most by k on either side.
  const double share = gap_m_ / model.target.LengthM();
  const double k = test_.PerspectiveMax(0);
  constexpr double kNoisePx = 1;  // centroid noise on a gap, generous: the exact test follows
  gap_min_px_ = std::max(0.5, model.length_min_px * share / (1 + k) - kNoisePx);
  gap_max_px_ = model.length_max_px * share * (1 + k) + kNoisePx;
}

void QuadrupleSearch::Run(const BlobGrid& grid, std::uint8_t target, long& budget, SightingSet& out) const {
  Base base{&grid, target, &budget, 0, 0, Vector2d::Zero(), Vector2d::Zero(), 0, 0};
  const Vector2d reach = Vector2d::Constant(gap_max_px_);
  const double share = gap_m_ / test_.GetModel().target.LengthM();
  for (base.first = 0; base.first < grid.size(); ++base.first) {
    base.origin_px = grid.Place(base.first);
    grid.VisitBox(base.origin_px - reach, base.origin_px + reach, [&](std::size_t second) {
      --budget;
      const Vector2d step = grid.Place(second) - base.origin_px;
      const double square = step.squaredNorm();
      if (square < gap_min_px_ * gap_min_px_ || square > gap_max_px_ * gap_max_px_ || budget < 0) return;
      base.second = second;
      base.gap_px = std::sqrt(square);
      base.along = step / base.gap_px;
      const double shortest_px = base.gap_px / share / (1 + test_.Options().perspective_max);
      base.perspective_max = test_.PerspectiveMax(shortest_px);
      SeekFar(base, out);
    });
    if (budget < 0) {
      out.cut_short = true;
      return;
    }
  }
}

double QuadrupleSearch::AlongPx(const Base& base, double ds_m, double gain_per_m) const {
  return base.gap_px * (ds_m / gap_m_) * (1 + gain_per_m * gap_m_) / (1 + gain_per_m * ds_m);
}

double QuadrupleSearch::Reach(const Base& base, std::size_t led) const {
  // Noise of the extrapolated line at `led`: the base's two ends, and the LED's own.
  const auto& leds_m = test_.GetModel().target.leds_m;
  const double r = (leds_m[led] - leds_m[base_]) / gap_m_;
  const double floor_px2 = test_.Options().centroid_floor_px * test_.Options().centroid_floor_px;
  const double variance = (1 - r) * (1 - r) * (base.grid->Variance(base.first) + floor_px2) +
                          r * r * (base.grid->Variance(base.second) + floor_px2) + base.grid->VarianceMax() +
                          floor_px2;
  constexpr double kCurvature = 1.5;  // perspective stretches the affine weights a little
  return kCurvature * test_.Options().sigmas * std::sqrt(variance);
}

void QuadrupleSearch::SeekFar(const Base& base, SightingSet& out) const {
  const auto& leds_m = test_.GetModel().target.leds_m;
  const double ds_m = leds_m[far_] - leds_m[base_];
  // c relates to Z at the base LED here and to Z at LED 1 in the bound; (1 + k) covers the difference.
  const double k = base.perspective_max;
  const double gain = k * (1 + k) / test_.GetModel().target.LengthM();
  const double a_px = AlongPx(base, ds_m, gain), b_px = AlongPx(base, ds_m, -gain);
  const double reach_px = Reach(base, far_);
  const double from_px = std::min(a_px, b_px) - reach_px, to_px = std::max(a_px, b_px) + reach_px;
  const Vector2d p = base.origin_px + from_px * base.along, q = base.origin_px + to_px * base.along;
  const Vector2d pad = Vector2d::Constant(reach_px);
  base.grid->VisitBox(p.cwiseMin(q) - pad, p.cwiseMax(q) + pad, [&](std::size_t far) {
    --*base.budget;
    const Vector2d place = base.grid->Place(far) - base.origin_px;
    const double along_px = base.along.dot(place);
    const double across_px = base.along.x() * place.y() - base.along.y() * place.x();
    if (along_px < from_px || along_px > to_px || std::abs(across_px) > reach_px) return;
    if (far == base.first || far == base.second) return;
    SeekRest(base, far, along_px, out);
  });
}

void QuadrupleSearch::SeekRest(const Base& base, std::size_t far, double far_px, SightingSet& out) const {
  const auto& leds_m = test_.GetModel().target.leds_m;
  const double far_m = leds_m[far_] - leds_m[base_], rest_m = leds_m[rest_] - leds_m[base_];
  // Three places fix the depth gain; the fourth follows. Its noise: the Lagrange weights of a parabola
  // through the other three, which is what a weak perspective amounts to.
  const double q = far_px * gap_m_ / (base.gap_px * far_m);
  const double gain_per_m = (1 - q) / (q * far_m - gap_m_);
  const double rest_px = AlongPx(base, rest_m, gain_per_m);
  if (!std::isfinite(rest_px)) return;  // the far blob stands on the base's
  const double weight_first = (rest_m - gap_m_) * (rest_m - far_m) / (gap_m_ * far_m);
  const double weight_second = rest_m * (rest_m - far_m) / (gap_m_ * (gap_m_ - far_m));
  const double weight_far = rest_m * (rest_m - gap_m_) / (far_m * (far_m - gap_m_));
  const double weights =
      1 + weight_first * weight_first + weight_second * weight_second + weight_far * weight_far;
  const double floor_px = test_.Options().centroid_floor_px;
  constexpr double kCurvature = 1.5;  // as in Reach
  const double reach_px = kCurvature * test_.Options().sigmas *
                          std::sqrt(weights * (base.grid->VarianceMax() + floor_px * floor_px));
  const Vector2d expected = base.origin_px + (base.grid->Place(far) - base.origin_px) * (rest_px / far_px);
  const Vector2d pad = Vector2d::Constant(reach_px);
  base.grid->VisitBox(expected - pad, expected + pad, [&](std::size_t rest) {
    --*base.budget;
    if ((base.grid->Place(rest) - expected).squaredNorm() > 2 * reach_px * reach_px) return;
    Quadruple leds;
    leds[base_] = base.first, leds[base_ + 1] = base.second, leds[far_] = far, leds[rest_] = rest;
    if (rest == base.first || rest == base.second || rest == far) return;
    auto sighting = test_.Judge(*base.grid, leds);
    if (!sighting) return;
    sighting->target = base.target;
    if (!out.sightings.push_back(*sighting)) ++out.no_room;
  });
}

}  // namespace adit::identify
