#include "firmware/stereo/other_readings.h"

#include <algorithm>
#include <array>

#include "firmware/stereo/correspondence.h"
#include "firmware/stereo/lit_place.h"

namespace adit::stereo {

using base::kLedCount;

namespace {

BarBlobs NoBlobs() {
  BarBlobs blobs;
  for (BlobIndices& side : blobs) side.fill(kNoBlob);
  return blobs;
}

}  // namespace

bool OtherReadings::Exist(const Question& question, const BarBuilder& builder) const {
  std::array<std::optional<LocatedPoint>, kLedCount> lights;
  for (std::size_t i = 0; i < kLedCount; ++i) lights[i] = Locate(*question.bar, i, builder);
  for (std::size_t i = 0; i < kLedCount; ++i) {
    for (std::size_t j = i + 1; j < kLedCount; ++j) {
      if (lights[i] && lights[j] && MayBeOthers(question, {i, j, *lights[i], *lights[j]}, builder))
        return true;
    }
  }
  return false;
}

/// The light that stands for an LED, if both images show it.
std::optional<LocatedPoint> OtherReadings::Locate(const Solution& bar, std::size_t led,
                                                  const BarBuilder& builder) const {
  const std::uint16_t left = bar.points.blobs[0][led], right = bar.points.blobs[1][led];
  if (left == kNoBlob || right == kNoBlob) return std::nullopt;
  const ObservationPair pair{ObservationOf(builder.Blobs(0).blobs[left]),
                             ObservationOf(builder.Blobs(1).blobs[right])};
  return TriangulateMidpoint(views_, pair, options_.centroid_floor_px);
}

/// The solution's cost, but without that of LEDs that may have merged with a light: one as bright as both.
double OtherReadings::Unexplained(const base::Target& target, const Solution& bar,
                                  const BarBuilder& builder) const {
  constexpr double kBesidePx = 1;  // to where an LED shines that has merged with what is in the box
  double cost = bar.chi_square;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& flux_dn = bar.points.flux_dn[side];
    const double typical_dn = *std::max_element(flux_dn.begin(), flux_dn.end());
    for (std::size_t i = 0; i < kLedCount; ++i) {
      const Hiding by{kBesidePx, kSameMake * typical_dn};
      if (bar.points.blobs[side][i] == kNoBlob &&
          !IsLit(rig_, builder.Blobs(side), side, bar.fit.PointM(target, target.leds_m[i]), by))
        cost += options_.hidden_cost;
    }
  }
  return cost;
}

bool OtherReadings::MayBeOthers(const Question& question, const Two& two, const BarBuilder& builder) const {
  const double cost_max =
      Unexplained(targets_[question.target], *question.bar, builder) + options_.chi_square_margin;
  const auto shows = [&](const base::Target& target, std::size_t first_as, std::size_t last_as) {
    BarBlobs blobs = NoBlobs();
    for (std::size_t side = 0; side < 2; ++side) {
      blobs[side][first_as] = question.bar->points.blobs[side][two.first];
      blobs[side][last_as] = question.bar->points.blobs[side][two.last];
    }
    LossReason unused;
    const auto pair = builder.Build(target, blobs, unused);
    return pair && Unexplained(target, builder.Completed(target, *pair, LedFlux{}), builder) < cost_max;
  };
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    if (!question.rivals[t] && t != question.target) continue;
    const base::Target& target = targets_[t];
    for (std::size_t i = 0; i < kLedCount; ++i) {
      for (std::size_t j = i + 1; j < kLedCount; ++j) {
        if (!DistanceFits(two.at_first, two.at_last, target.leds_m[j] - target.leds_m[i], options_)) continue;
        const bool is_own = t == question.target && i == two.first && j == two.last;
        if ((!is_own && shows(target, i, j)) || shows(target, j, i)) return true;
      }
    }
  }
  return false;
}

}  // namespace adit::stereo
