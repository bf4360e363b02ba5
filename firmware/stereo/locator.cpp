#include "firmware/stereo/locator.h"

#include <algorithm>

#include "firmware/stereo/bar_builder.h"
#include "firmware/stereo/expected_search.h"
#include "firmware/stereo/triple_bars.h"

namespace adit::stereo {

using base::kLedCount;
using identify::Sighting;

struct Locator::State {
  State(const optics::Rig& rig, const std::vector<base::Target>& all, const LocatorOptions& chosen_options)
      : targets(all),
        options(chosen_options),
        mirrors(rig, chosen_options),
        correspondence(rig, chosen_options),
        builder(rig, chosen_options),
        triple_bars(rig, all, chosen_options),
        expected_search(rig, chosen_options),
        findings(all.size()),
        chosen(all.size()) {}

  void TrySighting(const Sighting& sighting, const Expectation& expected);
  void TryBlobs(std::size_t target, const BarBlobs& blobs, const Expectation& expected);
  void SeekExpected(const ExpectationSet& expectations);
  bool MayBeOthers(std::size_t target, const Expectation& expected) const;
  std::bitset<identify::kMaxTargets> Wanted(const ExpectationSet& expectations) const;
  void ChooseAll(const ExpectationSet& expectations);

  std::vector<base::Target> targets;
  LocatorOptions options;
  Mirrors mirrors;
  Correspondence correspondence;
  BarBuilder builder;
  TripleBars triple_bars;
  ExpectedSearch expected_search;
  std::array<LedCandidates, kLedCount> candidates;
  std::vector<Finding> findings;
  std::vector<const Solution*> chosen;
  BlobFlags expected_blobs;  ///< where LEDs of targets that are followed are expected
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

/// Whether four lights are alike enough for LEDs of one bar. Dust and age are allowed half: with more, one of
/// them may have merged with a lamp, and the other three still show. Of a target that is followed, but not
/// expected there, no more is allowed than of three lights.
bool AreOfOneMake(const base::Target& target, const Expectation& expected, const Solution& solution) {
  constexpr float kAged = 1.5F;
  const bool elsewhere = expected.known && !IsExpected(target, expected, solution);
  return SameBrightness(LedFlux{}, solution.points.flux_dn, elsewhere ? kSameMake : kAged);
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

void Locator::State::TrySighting(const Sighting& sighting, const Expectation& expected) {
  Finding& finding = findings[sighting.target];
  bool on_line = true, makes_points = true;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    correspondence.Find(builder.Blobs(0).blobs[sighting.blobs[i]], candidates[i]);
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
    TryBlobs(sighting.target, {sighting.blobs, right_blobs}, expected);
  });
}

void Locator::State::TryBlobs(std::size_t target, const BarBlobs& blobs, const Expectation& expected) {
  Finding& finding = findings[target];
  LossReason reason = LossReason::kNone;
  const auto solution = builder.Build(targets[target], blobs, reason);
  const bool believed = solution && AreOfOneMake(targets[target], expected, *solution);
  if (solution && !believed) reason = LossReason::kAmbiguous;
  finding.reason = Farther(finding.reason, reason);
  if (believed) Add(options, *solution, finding);
}

void Locator::State::SeekExpected(const ExpectationSet& expectations) {
  for (auto& flags : expected_blobs) flags.reset();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Expectation& expected = expectations[i];
    if (!expected.known) continue;
    const auto is_expected = [&](const Solution& s) { return IsExpected(targets[i], expected, s); };
    if (std::any_of(findings[i].solutions.begin(), findings[i].solutions.end(), is_expected)) continue;
    expected_search.Run(targets[i], expected, builder, correspondence, findings[i]);
    expected_search.Mark(expected_blobs);
  }
}

/// Whether the four lights found may be something else: not alike, or a reflection of three LEDs that are not
/// found yet. Of a target seen a moment ago its own place tells: there was no reflection then, or it was
/// chosen, and from there it leads to any reflection.
bool Locator::State::MayBeOthers(std::size_t target, const Expectation& expected) const {
  if (!expected.recent) return true;
  const Solution place = ExpectedPlace(targets[target], expected);
  const auto& solutions = findings[target].solutions;
  return std::any_of(solutions.begin(), solutions.end(), [&](const Solution& s) {
    return MayBeMirrorImage(options, place, s) || !SameBrightness(LedFlux{}, s.points.flux_dn);
  });
}

/// The targets whose places with three LEDs are wanted. While a target is followed, what shows three of its
/// LEDs is where it is expected, and has been sought there; elsewhere it is another light.
std::bitset<identify::kMaxTargets> Locator::State::Wanted(const ExpectationSet& expectations) const {
  std::bitset<identify::kMaxTargets> wanted;
  for (std::size_t i = 0; i < targets.size(); ++i)
    wanted[i] = !expectations[i].known && (findings[i].solutions.empty() || MayBeOthers(i, expectations[i]));
  return wanted;
}

void Locator::State::ChooseAll(const ExpectationSet& expectations) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    // Nothing comes far in the half second that a target counts as seen a moment ago; its reflection is far
    // at once.
    const bool placed = expectations[i].known || expectations[i].recent;
    Solution place;
    if (placed) place = ExpectedPlace(targets[i], expectations[i]);
    chosen[i] = Choose(options, placed ? &place : nullptr, mirrors, findings[i]);
  }
  ResolveShared(options, chosen, findings);
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
  Locate(left, right, ExpectationSet{}, out);
}

void Locator::Locate(const identify::SightingSet& left, const identify::SightingSet& right,
                     const ExpectationSet& expectations, PointSet& out) {
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
    s.mirrors.Set(out.stamp.mid_exposure_ns);
    s.builder.Set(*left.blob_set, *right.blob_set);
    for (const Sighting& sighting : left.sightings) s.TrySighting(sighting, expectations[sighting.target]);
    s.SeekExpected(expectations);
    s.triple_bars.Run(s.Wanted(expectations), s.builder, s.correspondence, s.expected_blobs, s.findings);
    s.ChooseAll(expectations);
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
