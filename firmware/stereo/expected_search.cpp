#include "firmware/stereo/expected_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Bars that are tried per target and pair of images: six pairs of LEDs, and ten times as many for blobs that
/// stand beside them.
constexpr int kMaxBuilds = 60;

LocatedPoint ExpectedPoint(const Expectation& expected, double place_m) {
  const Matrix3d mixed = expected.covariance.topRightCorner<3, 3>();
  return {
      expected.led1_b_m + place_m * expected.direction_b,
      expected.covariance.topLeftCorner<3, 3>() +
          place_m * (mixed + mixed.transpose() + place_m * expected.covariance.bottomRightCorner<3, 3>())};
}

}  // namespace

Solution ExpectedPlace(const base::Target& target, const Expectation& expected) {
  Solution place;
  for (std::size_t i = 0; i < kLedCount; ++i)
    place.points.leds_b_m[i] = ExpectedPoint(expected, target.leds_m[i]).point_b_m;
  const LocatedPoint epicenter = ExpectedPoint(expected, target.epicenter_m);
  place.points.epicenter_b_m = epicenter.point_b_m;
  place.points.epicenter_covariance_m2 = epicenter.covariance_m2;
  place.flux_dn = HUGE_VAL;  // how bright it was is not known: anything may be its reflection
  return place;
}

bool IsExpected(const base::Target& target, const Expectation& expected, const Solution& solution) {
  const double limit = ChiSquareLimit(3, 4);
  for (const double place_m : {target.leds_m.front(), target.leds_m.back()}) {
    const LocatedPoint there = ExpectedPoint(expected, place_m);
    const Vector3d offset = solution.fit.PointM(target, place_m) - there.point_b_m;
    const Matrix3d covariance = there.covariance_m2 + solution.fit.PointCovarianceM2(target, place_m);
    if (!(offset.dot(covariance.ldlt().solve(offset)) <= limit)) return false;
  }
  return true;
}

ExpectedSearch::ExpectedSearch(const optics::Rig& rig, const LocatorOptions& options)
    : views_(MakeViews(rig)),
      options_(options),
      image_px2_{static_cast<double>(rig.left.width_px) * rig.left.height_px,
                 static_cast<double>(rig.right.width_px) * rig.right.height_px} {}

bool ExpectedSearch::CollectGate(const LocatedPoint& led, std::size_t side, const detect::BlobSet& blobs,
                                 Gate& gate) {
  gate.clear();
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 3> slope;
  if (!views_[side].Project(led.point_b_m, px, slope)) return true;
  // What the rig may have turned since the target was last seen is not in the expectation.
  const double aside_px = 0.5 * options_.epipolar_px;
  const double own_px2 = options_.centroid_floor_px * options_.centroid_floor_px + aside_px * aside_px;
  const Eigen::Matrix2d place_px2 =
      slope * led.covariance_m2 * slope.transpose() + own_px2 * Eigen::Matrix2d::Identity();
  const double limit = ChiSquareLimit(2, 4);
  if (side == 0)
    largest_gate_px2_ = std::max(largest_gate_px2_, M_PI * limit * std::sqrt(place_px2.determinant()));
  for (std::size_t i = 0; i < blobs.blobs.size(); ++i) {
    const Eigen::Vector2d offset = blobs.blobs[i].ideal_px - px;
    // The trace bounds the gate; written so that NaN is passed over.
    if (!(offset.squaredNorm() <= limit * (place_px2.trace() + blobs.blobs[i].covariance_px2.trace())))
      continue;
    const Eigen::Matrix2d all_px2 = place_px2 + blobs.blobs[i].covariance_px2;
    if (!(offset.dot(all_px2.inverse() * offset) <= limit)) continue;
    if (!gate.push_back(static_cast<std::uint16_t>(i))) return false;
  }
  return true;
}

bool ExpectedSearch::Collect(const base::Target& target, const Expectation& expected,
                             const BarBuilder& builder, const Correspondence& correspondence) {
  largest_gate_px2_ = 0;
  for (auto& pairs : pairs_) pairs.clear();
  for (std::size_t side = 0; side < 2; ++side)
    density_per_px2_[side] = static_cast<double>(builder.Blobs(side).blobs.size()) / image_px2_[side];
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const LocatedPoint led = ExpectedPoint(expected, target.leds_m[i]);
    std::array<Gate, 2> gates;
    for (std::size_t side = 0; side < 2; ++side) {
      if (!CollectGate(led, side, builder.Blobs(side), gates[side])) return false;
    }
    for (const std::uint16_t l : gates[0]) {
      const detect::Blob& left = builder.Blobs(0).blobs[l];
      const auto line = correspondence.LineOf(left);
      for (const std::uint16_t r : gates[1]) {
        const detect::Blob& right = builder.Blobs(1).blobs[r];
        if (!line || !correspondence.Near(*line, left, right)) continue;
        const auto located = TriangulateMidpoint(views_, {ObservationOf(left), ObservationOf(right)},
                                                 options_.centroid_floor_px);
        if (located && !pairs_[i].push_back({{l, r}, *located})) return false;
      }
    }
  }
  return true;
}

double ExpectedSearch::Chance() const {
  // The left blob stands in the gate, the right one on its epipolar line where the distance to the other LED
  // puts it; any of the three other LEDs.
  const double noise_px = 2 * options_.sigmas * options_.centroid_floor_px;
  const double right_px2 = 2 * (options_.epipolar_px + noise_px) * 2 * noise_px;
  return 3 * largest_gate_px2_ * density_per_px2_[0] * right_px2 * density_per_px2_[1];
}

void ExpectedSearch::TryPairs(const base::Target& target, const Expectation& expected,
                              const BarBuilder& builder, const std::array<std::size_t, 2>& leds,
                              Finding& finding) {
  const double gap_m = target.leds_m[leds[1]] - target.leds_m[leds[0]];
  for (const Pair& a : pairs_[leds[0]]) {
    for (const Pair& b : pairs_[leds[1]]) {
      if (a.blobs[0] == b.blobs[0] || a.blobs[1] == b.blobs[1]) continue;
      if (!DistanceFits(a.located, b.located, gap_m, options_)) continue;
      BarBlobs blobs;
      for (std::size_t side = 0; side < 2; ++side) {
        blobs[side].fill(kNoBlob);
        blobs[side][leds[0]] = a.blobs[side], blobs[side][leds[1]] = b.blobs[side];
      }
      const auto explains = [&blobs](const Solution& s) { return Explains(s, blobs); };
      if (std::any_of(finding.solutions.begin(), finding.solutions.end(), explains)) continue;
      if (++builds_ > kMaxBuilds) return;
      LossReason unused;
      const auto bar = builder.Build(target, blobs, unused);
      if (!bar || !IsExpected(target, expected, *bar)) continue;
      if (!SameBrightness(expected.flux_dn, bar->points.flux_dn)) continue;
      Solution all = builder.Completed(target, *bar, expected.flux_dn);
      const bool bare = all.points.blobs == blobs;
      const bool usual = all.chi_square <= ChiSquareLimit(2 * all.seen - 5, options_.candidate_sigmas);
      if (!usual && std::popcount(all.points.recovered_mask) > 1) continue;
      // Of two LEDs no third tells that one has merged with a dim light.
      if (bare && (Chance() > options_.expected_chance_max ||
                   !SameBrightness(expected.flux_dn, all.points.flux_dn, kSameLed)))
        continue;
      // That it was expected here is worth an LED, hidden in both images: the better place of two here is the
      // one that shows more LEDs.
      all.cost -= 2 * options_.hidden_cost;
      Add(options_, all, finding);
    }
  }
}

void ExpectedSearch::Mark(BlobFlags& flags) const {
  for (const auto& pairs : pairs_) {
    for (const Pair& pair : pairs) {
      for (std::size_t side = 0; side < 2; ++side) flags[side].set(pair.blobs[side]);
    }
  }
}

void ExpectedSearch::Run(const base::Target& target, const Expectation& expected, const BarBuilder& builder,
                         const Correspondence& correspondence, Finding& finding) {
  if (!Collect(target, expected, builder, correspondence)) return;
  builds_ = 0;
  constexpr std::array<std::array<std::size_t, 2>, 6> kWidestFirst{
      {{0, 3}, {1, 3}, {0, 2}, {2, 3}, {1, 2}, {0, 1}}};
  for (const auto& leds : kWidestFirst) TryPairs(target, expected, builder, leds, finding);
  if (builds_ > kMaxBuilds) finding.crowded = true;
}

}  // namespace adit::stereo
