#include "firmware/stereo/triple_bars.h"

#include <algorithm>

namespace adit::stereo {

using base::kLedCount;

namespace {

/// Whether every one of the points is an LED of the bar.
bool Holds(const Solution& bar, const NearMiss& near) {
  const auto is_led = [&bar](const std::array<std::uint16_t, 2>& point) {
    for (std::size_t i = 0; i < kLedCount; ++i) {
      if (bar.points.blobs[0][i] == point[0] && bar.points.blobs[1][i] == point[1]) return true;
    }
    return false;
  };
  return std::all_of(near.blobs.begin(), near.blobs.end(), is_led);
}

}  // namespace

TripleBars::TripleBars(const optics::Rig& rig, const std::vector<base::Target>& targets,
                       const LocatorOptions& options)
    : targets_(targets), options_(options), cloud_(rig, options), search_(rig, targets, options) {}

void TripleBars::Run(const std::bitset<identify::kMaxTargets>& wanted, const BarBuilder& builder,
                     const Correspondence& correspondence, std::vector<Finding>& findings) {
  if (wanted.none()) return;
  Claim(findings);
  cloud_.Build(builder.Blobs(0), builder.Blobs(1), claimed_, correspondence);
  search_.Run(cloud_, wanted, triples_);
  if (triples_.cut_short) return;
  bars_.clear();
  for (const Triple& triple : triples_.triples) Try(triple, builder, findings);
  if (bars_.empty()) return;
  chance_ = triples_.chance;
  for (const NearMiss& near : triples_.near) {
    if (!IsExplained(near, findings)) chance_[near.target] += near.chance;
  }
  for (const Bar& bar : bars_) {
    Finding& finding = findings[bar.triple.target];
    // All four LEDs in both images are as good as those that the left image showed first.
    const bool believed = bar.solution.complete || ChanceOf(bar) <= options_.chance_max;
    if (bars_.Full() || !believed || IsContested(bar)) {
      // It came as far as any hypothesis can.
      if (finding.solutions.empty()) finding.reason = LossReason::kAmbiguous;
      continue;
    }
    Add(options_, bar.solution, finding);
  }
}

void TripleBars::Claim(const std::vector<Finding>& findings) {
  for (auto& flags : claimed_) flags.reset();
  for (const Finding& finding : findings) {
    for (const Solution& solution : finding.solutions) {
      if (!solution.complete) continue;
      for (std::size_t side = 0; side < 2; ++side) {
        for (const std::uint16_t blob : solution.points.blobs[side]) claimed_[side].set(blob);
      }
    }
  }
}

void TripleBars::Try(const Triple& triple, const BarBuilder& builder, const std::vector<Finding>& findings) {
  const auto explains = [&triple](const Solution& s) { return Explains(s, triple.blobs); };
  const auto& known = findings[triple.target].solutions;
  if (std::any_of(known.begin(), known.end(), explains)) return;
  LossReason unused;
  const base::Target& target = targets_[triple.target];
  const auto bar = builder.Build(target, triple.blobs, unused);
  if (!bar) return;
  Bar all{triple, builder.Completed(target, *bar)};
  all.solution.points.target = triple.target;
  bars_.push_back(all);
}

double TripleBars::ChanceOf(const Bar& bar) const {
  // Every further blob that stands where the fit puts an LED makes chance rarer: a thousand times in a
  // picture of scattered lamps, ten times in a row of them.
  constexpr double kRarer = 0.1;
  double chance = chance_[bar.triple.target];
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < kLedCount; ++i)
      chance *= bar.solution.points.blobs[side][i] != bar.triple.blobs[side][i] ? kRarer : 1;
  }
  return chance;
}

/// Another target may be seen in the same blobs, whether or not it is believed.
bool TripleBars::IsContested(const Bar& bar) const {
  return std::any_of(bars_.begin(), bars_.end(), [&](const Bar& other) {
    return other.triple.target != bar.triple.target && ShareABlob(other.solution, bar.solution) &&
           other.solution.cost < bar.solution.cost + options_.chi_square_margin;
  });
}

/// Near misses of a bar's own LEDs, read the other way round or for another target, are no chance.
bool TripleBars::IsExplained(const NearMiss& near, const std::vector<Finding>& findings) const {
  const auto holds = [&near](const Solution& s) { return Holds(s, near); };
  return std::any_of(bars_.begin(), bars_.end(), [&](const Bar& bar) { return holds(bar.solution); }) ||
         std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
           return std::any_of(finding.solutions.begin(), finding.solutions.end(), holds);
         });
}

}  // namespace adit::stereo
