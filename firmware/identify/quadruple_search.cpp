#include "firmware/identify/quadruple_search.h"

#include <algorithm>
#include <cmath>

namespace adit::identify {

using Eigen::Vector2d;

namespace {

constexpr double kFarOffPx = 1e6;  // outside any image

}  // namespace

struct QuadrupleSearch::Base {
  const BlobGrid* grid;
  std::uint8_t target;
  long* budget;
  std::size_t first, second;  ///< grid places of LED base_ and the next
  Vector2d origin_px, along;
  double gap_px;
  double noise_px;  ///< of the noisiest centroid, floor included
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
  const auto distance = [&](std::size_t i) {
    return i < base_ ? leds_m[base_] - leds_m[i] : leds_m[i] - leds_m[base_ + 1];
  };
  third_ = base_ == 0 ? 2 : base_ == 2 ? 1 : distance(0) < distance(3) ? 0 : 3;
  for (std::size_t i = 0; i < leds_m.size(); ++i) {
    if (i != base_ && i != base_ + 1 && i != third_) fourth_ = i;
  }
  third_m_ = leds_m[third_] - leds_m[base_], fourth_m_ = leds_m[fourth_] - leds_m[base_];
  // How the noise of the base extrapolates to the third LED's place, and that of the three to the fourth's:
  // Lagrange's weights of a line, and of a parabola, which is what a weak perspective amounts to.
  constexpr double kCurvature = 1.5;  // it stretches them a little; the exact test follows
  const double r = third_m_ / gap_m_;
  third_reach_ = kCurvature * options.sigmas * std::sqrt(1 + (1 - r) * (1 - r) + r * r);
  const double w1 = (fourth_m_ - gap_m_) * (fourth_m_ - third_m_) / (gap_m_ * third_m_);
  const double w2 = fourth_m_ * (fourth_m_ - third_m_) / (gap_m_ * (gap_m_ - third_m_));
  const double w3 = fourth_m_ * (fourth_m_ - gap_m_) / (third_m_ * (third_m_ - gap_m_));
  fourth_reach_ = kCurvature * options.sigmas * std::sqrt(1 + w1 * w1 + w2 * w2 + w3 * w3);
  // The gap's share of the image's length changes by the perspective, at most by k on either side.
  const double share = gap_m_ / model.target.LengthM();
  const double k = test_.PerspectiveMax(model.length_min_px);
  constexpr double kNoisePx = 1;  // centroid noise on a gap, generous: the exact test follows
  gap_min_px_ = std::max(0.5, model.length_min_px * share / (1 + k) - kNoisePx);
  gap_max_px_ = model.length_max_px * share * (1 + k) + kNoisePx;
  // The depth gain relates to the base LED here and to LED 1 in k; (1 + k) covers the difference.
  const double gain_per_m = k * (1 + k) / model.target.LengthM();
  third_from_ = std::min(AlongGaps(third_m_, gain_per_m), AlongGaps(third_m_, -gain_per_m));
  third_to_ = std::max(AlongGaps(third_m_, gain_per_m), AlongGaps(third_m_, -gain_per_m));
  const double a = AlongGaps(fourth_m_, gain_per_m), b = AlongGaps(fourth_m_, -gain_per_m);
  fourth_nearest_ = std::abs(a) < std::abs(b) ? a : b;
}

void QuadrupleSearch::Run(const BlobGrid& grid, std::uint8_t target, long& budget, SightingSet& out) const {
  Base base{&grid, target, &budget, 0, 0, Vector2d::Zero(), Vector2d::Zero(), 0, 0};
  const double floor_px = test_.Options().centroid_floor_px;
  base.noise_px = std::sqrt(grid.VarianceMax() + floor_px * floor_px);
  const Vector2d reach = Vector2d::Constant(gap_max_px_);
  const double min_px2 = gap_min_px_ * gap_min_px_, max_px2 = gap_max_px_ * gap_max_px_;
  for (base.first = 0; base.first < grid.size(); ++base.first) {
    base.origin_px = grid.Place(base.first);
    grid.VisitBox(base.origin_px - reach, base.origin_px + reach, [&](std::size_t second) {
      --budget;
      const Vector2d step = grid.Place(second) - base.origin_px;
      const double square = step.squaredNorm();
      if (square < min_px2 || square > max_px2 || budget < 0) return;
      base.second = second;
      // A long bar must end in the image: most pairs of far blobs point out of it.
      const Vector2d fourth = base.origin_px + fourth_nearest_ * step;
      if (!grid.Encloses(fourth, fourth_reach_ * base.noise_px)) return;
      base.gap_px = std::sqrt(square);
      base.along = step / base.gap_px;
      SeekThird(base, out);
    });
    if (budget < 0) {
      out.cut_short = true;
      return;
    }
  }
}

void QuadrupleSearch::SeekThird(const Base& base, SightingSet& out) const {
  const double reach_px = third_reach_ * base.noise_px;
  const double from_px = third_from_ * base.gap_px - reach_px, to_px = third_to_ * base.gap_px + reach_px;
  const Vector2d p = base.origin_px + from_px * base.along, q = base.origin_px + to_px * base.along;
  base.grid->VisitStrip(p, q, reach_px, [&](std::size_t third) {
    --*base.budget;
    const Vector2d place = base.grid->Place(third) - base.origin_px;
    const double along_px = base.along.dot(place);
    const double across_px = base.along.x() * place.y() - base.along.y() * place.x();
    if (along_px < from_px || along_px > to_px || std::abs(across_px) > reach_px) return;
    if (third == base.first || third == base.second) return;
    SeekFourth(base, third, along_px, out);
  });
}

void QuadrupleSearch::SeekFourth(const Base& base, std::size_t third, double third_px,
                                 SightingSet& out) const {
  // Three places fix the depth gain; the fourth follows.
  const double q = third_px * gap_m_ / (base.gap_px * third_m_);
  const double gain_per_m = (1 - q) / (q * third_m_ - gap_m_);
  const double fourth_px = base.gap_px * AlongGaps(fourth_m_, gain_per_m);
  const Vector2d expected =
      base.origin_px + (base.grid->Place(third) - base.origin_px) * (fourth_px / third_px);
  const double reach_px = fourth_reach_ * base.noise_px;
  // Written so that NaN ends here: the third blob stands on one of the base's.
  if (!(expected.squaredNorm() < kFarOffPx * kFarOffPx)) return;
  const Vector2d pad = Vector2d::Constant(reach_px);
  base.grid->VisitBox(expected - pad, expected + pad, [&](std::size_t fourth) {
    --*base.budget;
    if (!((base.grid->Place(fourth) - expected).squaredNorm() <= 2 * reach_px * reach_px)) return;
    if (fourth == base.first || fourth == base.second || fourth == third) return;
    Quadruple leds;
    leds[base_] = base.first, leds[base_ + 1] = base.second, leds[third_] = third, leds[fourth_] = fourth;
    auto sighting = test_.Judge(*base.grid, leds);
    if (!sighting) return;
    sighting->target = base.target;
    if (!out.sightings.push_back(*sighting)) ++out.no_room;
  });
}

}  // namespace adit::identify
