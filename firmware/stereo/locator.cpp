#include "firmware/stereo/locator.h"

#include <algorithm>

#include "firmware/stereo/choice.h"
#include "firmware/stereo/correspondence.h"
#include "firmware/stereo/solution.h"

namespace adit::stereo {

using base::kLedCount;
using identify::Sighting;

struct Locator::State {
  State(const optics::Rig& rig, const std::vector<base::Target>& all, const LocatorOptions& chosen_options)
      : targets(all),
        options(chosen_options),
        views(MakeViews(rig)),
        correspondence(rig, chosen_options),
        solver(rig, chosen_options),
        findings(all.size()),
        chosen(all.size()) {}

  void TrySighting(const identify::SightingSet& left, const identify::SightingSet& right,
                   const Sighting& sighting);
  void TryRightBlobs(const identify::SightingSet& left, const identify::SightingSet& right,
                     const Sighting& sighting, const BlobIndices& right_blobs);

  std::vector<base::Target> targets;
  LocatorOptions options;
  Views views;
  Correspondence correspondence;
  Solver solver;
  std::array<LedCandidates, kLedCount> candidates;
  std::vector<Finding> findings;
  std::vector<const Solution*> chosen;
};

namespace {

/// Of two reasons the one of the hypothesis that came farther.
LossReason Farther(LossReason a, LossReason b) {
  const auto rank = [](LossReason reason) {
    switch (reason) {
      case LossReason::kNone:
        return 5;
      case LossReason::kAmbiguous:
        return 4;
      case LossReason::kDistances:
        return 3;
      case LossReason::kGeometry:
        return 2;
      case LossReason::kNoCorrespondence:
        return 1;
      case LossReason::kNotSeen:
      case LossReason::kNoFrame:
      case LossReason::kOneBar:
      case LossReason::kJump:
        return 0;
    }
    return 0;
  };
  return rank(a) >= rank(b) ? a : b;
}

/// Calls visit(right blobs) for every way to take one candidate per LED so that all distances fit.
template <class Visit>
void VisitAssignments(const base::Target& target, const std::array<LedCandidates, kLedCount>& candidates,
                      const LocatorOptions& options, Visit visit) {
  std::array<const Candidate*, kLedCount> taken{};
  const auto fits = [&](std::size_t led) {
    for (std::size_t i = 0; i < led; ++i) {
      if (taken[i]->blob == taken[led]->blob) return false;
      if (!DistanceFits(taken[i]->located, taken[led]->located, target.leds_m[led] - target.leds_m[i],
                        options))
        return false;
    }
    return true;
  };
  const auto descend = [&](const auto& self, std::size_t led) -> void {
    if (led == kLedCount) {
      visit(BlobIndices{taken[0]->blob, taken[1]->blob, taken[2]->blob, taken[3]->blob});
      return;
    }
    for (const Candidate& candidate : candidates[led].candidates) {
      taken[led] = &candidate;
      if (fits(led)) self(self, led + 1);
    }
  };
  descend(descend, 0);
}

}  // namespace

void Locator::State::TrySighting(const identify::SightingSet& left, const identify::SightingSet& right,
                                 const Sighting& sighting) {
  Finding& finding = findings[sighting.target];
  bool on_line = true, makes_points = true;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    correspondence.Find(left.blob_set->blobs[sighting.blobs[i]], candidates[i]);
    on_line = on_line && candidates[i].on_line;
    makes_points = makes_points && !candidates[i].candidates.empty();
    if (candidates[i].crowded) finding.crowded = true;
  }
  if (!makes_points) {
    const LossReason reason = on_line ? LossReason::kGeometry : LossReason::kNoCorrespondence;
    finding.reason = Farther(finding.reason, reason);
    return;
  }
  finding.reason = Farther(finding.reason, LossReason::kDistances);
  VisitAssignments(targets[sighting.target], candidates, options, [&](const BlobIndices& right_blobs) {
    TryRightBlobs(left, right, sighting, right_blobs);
  });
}

void Locator::State::TryRightBlobs(const identify::SightingSet& left, const identify::SightingSet& right,
                                   const Sighting& sighting, const BlobIndices& right_blobs) {
  Finding& finding = findings[sighting.target];
  BarObservations observations;
  double flux_dn = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const detect::Blob& blob = left.blob_set->blobs[sighting.blobs[i]];
    observations[i] = {ObservationOf(blob), ObservationOf(right.blob_set->blobs[right_blobs[i]])};
    flux_dn += static_cast<double>(blob.flux_dn);
  }
  LossReason reason = LossReason::kNone;
  auto solution = solver.Solve(targets[sighting.target], observations, reason);
  finding.reason = Farther(finding.reason, reason);
  if (!solution) return;
  solution->flux_dn = flux_dn;
  solution->points.blobs = {sighting.blobs, right_blobs};
  solution->points.target = sighting.target;
  if (!finding.solutions.push_back(*solution)) finding.crowded = true;
}

Locator::Locator(const optics::Rig& rig, const std::vector<base::Target>& targets,
                 const LocatorOptions& options)
    : state_(std::make_unique<State>(rig, targets, options)) {
  ADIT_REQUIRE(targets.size() <= identify::kMaxTargets);
}

Locator::~Locator() = default;
Locator::Locator(Locator&&) noexcept = default;
Locator& Locator::operator=(Locator&&) noexcept = default;

void Locator::Locate(const identify::SightingSet& left, const identify::SightingSet& right, PointSet& out) {
  State& s = *state_;
  const base::FrameStamp& left_stamp = left.blob_set->stamp;
  const base::FrameStamp& right_stamp = right.blob_set->stamp;
  // A pair whose left frame never came is dated by its right one.
  out.stamp = left_stamp.mid_exposure_ns != base::kNever ? left_stamp : right_stamp;
  out.stamp.last_packet_ns = std::max(left_stamp.last_packet_ns, right_stamp.last_packet_ns);
  out.left = &left;
  out.right = &right;
  const bool usable =
      left_stamp.status == base::FrameStatus::kOk && right_stamp.status == base::FrameStatus::kOk;
  for (std::size_t i = 0; i < s.targets.size(); ++i) {
    s.findings[i].solutions.clear();
    s.findings[i].crowded = false;
    s.findings[i].reason = usable ? LossReason::kNotSeen : LossReason::kNoFrame;
    s.chosen[i] = nullptr;
  }
  if (usable) {
    s.correspondence.SetRight(*right.blob_set);
    for (const Sighting& sighting : left.sightings) s.TrySighting(left, right, sighting);
    for (std::size_t i = 0; i < s.targets.size(); ++i)
      s.chosen[i] = Choose(s.views, s.options, s.findings[i]);
    ResolveShared(s.options, s.chosen, s.findings);
  }
  out.targets.clear();
  for (std::size_t i = 0; i < s.targets.size(); ++i) {
    TargetPoints points;
    if (s.chosen[i] != nullptr) points = s.chosen[i]->points;
    points.target = static_cast<std::uint8_t>(i);
    points.reason = s.chosen[i] != nullptr ? LossReason::kNone : s.findings[i].reason;
    out.targets.push_back(points);
  }
}

}  // namespace adit::stereo
