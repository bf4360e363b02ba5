#include "firmware/stereo/triple_search.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Pairs of points that are looked at before the search gives up: about 0.3 ms.
constexpr long kBudget = 200'000;

}  // namespace

/// Two points taken for two LEDs of a target.
struct TripleSearch::Outer {
  std::size_t target = 0, first = 0, last = 0;  ///< LED indices, first < last
  const CloudPoint* a = nullptr;                ///< stands for LED `first`
  const CloudPoint* b = nullptr;
};

TripleSearch::TripleSearch(const optics::Rig& rig, const std::vector<base::Target>& targets,
                           const LocatorOptions& options)
    : targets_(targets),
      options_(options),
      focal_px_(std::max(rig.left.fu_px, rig.left.fv_px)),
      width_px_(rig.right.width_px) {
  for (const base::Target& target : targets) longest_m_ = std::max(longest_m_, target.LengthM());
}

void TripleSearch::Run(const PointCloud& cloud, const std::bitset<identify::kMaxTargets>& wanted,
                       TripleSet& out) const {
  out.triples.clear();
  out.chance.fill(0);
  out.cut_short = cloud.Crowded();
  long budget = kBudget;
  constexpr double kOffAxis = 1.25;  // squared field angle of 27 degrees
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint& a = cloud[i];
    // The other end may be nearer by the bar's length and then is farther off in the image.
    const double nearest_m = std::max(a.depth_m[0] - longest_m_, 0.5 * a.depth_m[0]);
    const double reach_px = kOffAxis * focal_px_ * longest_m_ / nearest_m;
    for (std::size_t j = i + 1; j < cloud.size(); ++j) {
      const CloudPoint& b = cloud[j];
      if (b.px[0].x() - a.px[0].x() > reach_px) break;
      if (--budget < 0) {
        out.cut_short = true;
        return;
      }
      const Vector3d apart_m = b.point_b_m - a.point_b_m;
      const double longest_m =
          (1 + options_.scale) * longest_m_ + options_.sigmas * (a.range_sigma_m + b.range_sigma_m);
      if (!(apart_m.squaredNorm() <= longest_m * longest_m)) continue;
      if (a.blobs[0] == b.blobs[0] || a.blobs[1] == b.blobs[1]) continue;
      TryPair(cloud, {0, 0, 0, &a, &b}, wanted, out);
    }
  }
}

void TripleSearch::TryPair(const PointCloud& cloud, const Outer& pair,
                           const std::bitset<identify::kMaxTargets>& wanted, TripleSet& out) const {
  const Vector3d apart_m = pair.b->point_b_m - pair.a->point_b_m;
  const double distance_m = apart_m.norm();
  const double lean = apart_m.dot(pair.a->point_b_m) / (distance_m * pair.a->point_b_m.norm());
  const double range_m2 =
      pair.a->range_sigma_m * pair.a->range_sigma_m + pair.b->range_sigma_m * pair.b->range_sigma_m;
  const double noise_px = std::max(pair.a->noise_px, pair.b->noise_px);
  const double across_m = noise_px * pair.a->depth_m[0] / focal_px_;
  const double within_m = options_.sigmas * std::sqrt(lean * lean * range_m2 + 2 * across_m * across_m);
  // The lean is itself uncertain where the bar stands across the view: a second-order term of the depths.
  const double curved_m = 0.5 * options_.sigmas * options_.sigmas * range_m2 / distance_m;
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    if (!wanted[t]) continue;
    const auto& leds_m = targets_[t].leds_m;
    for (const auto& [first, last] : {std::pair{0U, 2U}, std::pair{0U, 3U}, std::pair{1U, 3U}}) {
      const double gap_m = leds_m[last] - leds_m[first];
      if (!(std::abs(distance_m - gap_m) <= within_m + curved_m + options_.scale * gap_m)) continue;
      for (std::size_t inner = first + 1; inner < last; ++inner) {
        SeekInner(cloud, {t, first, last, pair.a, pair.b}, inner, out);
        SeekInner(cloud, {t, first, last, pair.b, pair.a}, inner, out);
      }
    }
  }
}

TripleSearch::Gates TripleSearch::GatesOf(const Outer& pair, std::size_t inner) const {
  const auto& leds_m = targets_[pair.target].leds_m;
  const double gap_m = leds_m[pair.last] - leds_m[pair.first];
  const double r = (leds_m[inner] - leds_m[pair.first]) / gap_m;
  Gates gates;
  for (std::size_t side = 0; side < 2; ++side) {
    const Vector2d step = pair.b->px[side] - pair.a->px[side];
    const double far_m = r * pair.b->depth_m[side];
    const double w = far_m / (far_m + (1 - r) * pair.a->depth_m[side]);
    const double length_px = step.norm();
    Gate& gate = gates[side];
    gate.px = pair.a->px[side] + w * step;
    // An end-on bar has no direction in the image; any does.
    gate.along = length_px > 0 ? Vector2d(step / length_px) : Vector2d(Vector2d::UnitX());
    gate.noise_px = std::max(pair.a->noise_px, pair.b->noise_px);
    gate.tight_px = options_.sigmas * gate.noise_px * std::sqrt(1 + w * w + (1 - w) * (1 - w));
  }
  return gates;
}

double TripleSearch::ChanceOf(const PointCloud& cloud, const Gates& gates) const {
  // Unrelated blobs in both gates, and lamps in the left one whose own place in the right image is in the
  // other one.
  const auto area_px2 = [](const Gate& gate) { return 4 * gate.tight_px * gate.tight_px; };
  return area_px2(gates[0]) * cloud.BlobsPerPx2()[0] *
         (area_px2(gates[1]) * cloud.BlobsPerPx2()[1] + 2 * gates[1].tight_px / width_px_);
}

void TripleSearch::SeekInner(const PointCloud& cloud, const Outer& pair, std::size_t inner,
                             TripleSet& out) const {
  const Gates gates = GatesOf(pair, inner);
  out.chance[pair.target] += ChanceOf(cloud, gates);
  constexpr double kNoisiest = 4;  // a blob that much noisier than the outer two is no help
  const double reach_px = kNoisiest * gates[0].tight_px;
  for (std::size_t i = cloud.FirstFrom(gates[0].px.x() - reach_px);
       i < cloud.size() && cloud[i].px[0].x() <= gates[0].px.x() + reach_px; ++i) {
    const CloudPoint& c = cloud[i];
    bool tight = true;
    for (std::size_t side = 0; side < 2; ++side) {
      const Gate& gate = gates[side];
      const Vector2d offset = c.px[side] - gate.px;
      const double tight_px = gate.tight_px * std::clamp(c.noise_px / gate.noise_px, 1.0, kNoisiest);
      const double along_px = std::abs(gate.along.dot(offset));
      const double across_px = std::abs(gate.along.x() * offset.y() - gate.along.y() * offset.x());
      tight = tight && across_px <= tight_px && along_px <= tight_px;
    }
    const auto is_other = [&c](const CloudPoint& end) {
      return c.blobs[0] != end.blobs[0] && c.blobs[1] != end.blobs[1];
    };
    if (!tight || !is_other(*pair.a) || !is_other(*pair.b)) continue;
    Triple triple;
    triple.target = static_cast<std::uint8_t>(pair.target);
    for (std::size_t side = 0; side < 2; ++side) {
      triple.blobs[side].fill(kNoBlob);
      triple.blobs[side][pair.first] = pair.a->blobs[side];
      triple.blobs[side][pair.last] = pair.b->blobs[side];
      triple.blobs[side][inner] = c.blobs[side];
    }
    if (!out.triples.push_back(triple)) out.cut_short = true;
  }
}

}  // namespace adit::stereo
