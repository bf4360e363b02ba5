// Fifteen bars of 1 m at 110 m.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "host/crew.h"
#include "host/target_tally.h"
#include "host/tunnel.h"
#include "host/underground_cases.h"

namespace adit::host {
namespace {

constexpr std::size_t kBars = 15, kTogether = 5;
constexpr double kDistanceM = 110, kNoisePx = 0.05;
constexpr std::size_t kFifteenFrames = 20;

/// Places of the two inner LEDs of a bar of 1 m.
using Inner = std::array<double, 2>;

/// How far apart two bars are, the second perhaps read backwards.
double LayoutsApart(const Inner& a, const Inner& b) {
  return std::min(std::hypot(a[0] - b[0], a[1] - b[1]), std::hypot(a[0] - (1 - b[1]), a[1] - (1 - b[0])));
}

/// Layouts with gaps of at least 0.15 m, in steps of 10 mm, whose direction can be told; each next one as far
/// from those before as can be.
std::vector<base::Target> FifteenTargets() {
  constexpr int kGapCm = 15;
  std::vector<Inner> all, taken;
  for (int u = kGapCm; u <= 100 - 2 * kGapCm; ++u) {
    for (int v = u + kGapCm; v <= 100 - kGapCm; ++v) {
      // The half of the layouts that starts with the shorter gap: the others are these, turned round.
      if (u + 6 <= 100 - v) all.push_back({u / 100.0, v / 100.0});
    }
  }
  taken.push_back(all.front());
  const auto alone = [&taken](const Inner& layout) {
    double nearest = 1;
    for (const Inner& other : taken) nearest = std::min(nearest, LayoutsApart(layout, other));
    return nearest;
  };
  while (taken.size() < kBars) {
    taken.push_back(*std::max_element(all.begin(), all.end(),
                                      [&](const Inner& a, const Inner& b) { return alone(a) < alone(b); }));
  }
  std::vector<base::Target> targets;
  for (const Inner& layout : taken)
    targets.push_back({"bar" + std::to_string(targets.size() + 1), {0, layout[0], layout[1], 1}, 0.5, 0.04});
  return targets;
}

/// Some of the bars; the names of those that are not in view must stay unused.
struct FifteenTally {
  TargetTally targets;
  std::size_t absent = 0;
};

FifteenTally CountBars(std::uint64_t seed, const std::vector<base::Target>& targets, std::size_t piece) {
  Tunnel tunnel(seed, TunnelRig(9));
  Tunnel::Ride ride;
  ride.nearest_m = ride.farthest_m = kDistanceM;
  ride.seconds = kFifteenFrames / 60.0;
  // The first of the models are those in view, so that the indices of scene and models agree.
  std::vector<base::Target> order = targets;
  std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(piece % kBars), order.end());
  for (std::size_t i = 0; i < kTogether; ++i) tunnel.AddTarget(order[i], ride);
  Episode episode(tunnel.Take(), ModelsOf(order), Imaging::kCentroids);
  episode.Centroids().FixNoise(kNoisePx);
  episode.Centroids().RunTogether(false);
  TargetCounter counter(episode, "piece " + std::to_string(piece));
  FifteenTally tally;
  for (std::size_t trigger = 0; trigger < kFifteenFrames; ++trigger) {
    const auto& result = episode.Expose(trigger);
    counter.Count(trigger, result);
    for (std::size_t i = kTogether; i < kBars; ++i)
      tally.absent += result.fixes.targets[i].state.points.status != stereo::FixStatus::kLost ? 1 : 0;
  }
  tally.targets = counter.Take();
  return tally;
}

}  // namespace

SuiteReport MeasureFifteen(const CaseOrder& order) {
  const auto targets = FifteenTargets();
  const std::size_t pieces = std::max(kBars, order.CountOr(15'000) / (kTogether * kFifteenFrames));
  const auto tallies = WorkInParallel<FifteenTally>(
      "fifteen", pieces, [&](std::size_t i) { return CountBars(PieceSeed(order, i), targets, i); });
  FifteenTally sum;
  for (const FifteenTally& tally : tallies) {
    sum.targets.Add(tally.targets);
    sum.absent += tally.absent;
  }
  SuiteReport report;
  report.how =
      std::to_string(sum.targets.target_frames) +
      " target-frames of fifteen bars of 1 m at 110 m, five at a time, centroids with 0.05 px of noise, "
      "none rendered";
  report.AtMost("wrong names", static_cast<double>(sum.targets.swapped), 0, "", 0);
  report.AtMost("names of bars that are not there", static_cast<double>(sum.absent), 0, "", 0);
  report.AtMost("off by more than 5 sigma + 10 mm", static_cast<double>(sum.targets.off_tracked), 0, "", 0);
  report.AtLeast("named rightly", sum.targets.any.Pct(), 99, "%", 3);
  report.findings = sum.targets.findings;
  return report;
}

}  // namespace adit::host
