#include "host/target_tally.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace adit::host {
namespace {

constexpr std::size_t kFindingsMax = 12, kWrongMax = 3, kLostMax = 1;  // of a campaign, of an episode
constexpr const char* kLostWord = "lost";
constexpr int kReacquiredWithin = 2;  // pairs

const char* ReasonName(stereo::LossReason reason) {
  constexpr std::array<const char*, 7> kNames{"none",      "no frame",  "not seen", "no correspondence",
                                              "distances", "ambiguous", "geometry"};
  const auto i = static_cast<std::size_t>(reason);
  return i < kNames.size() ? kNames[i] : "other";
}

/// What each camera can measure of LED 1 to 4: v(isible), o(ff), b(order), h(idden), c(rowded).
std::string ViewsOf(const sim::TargetTruth& truth) {
  constexpr std::array<char, 5> kLetters{'v', 'o', 'b', 'h', 'c'};
  std::string text;
  for (const auto& side : truth.views) {
    for (const sim::LedView view : side) text += kLetters[static_cast<std::size_t>(view)];
    text += &side == &truth.views.front() ? "/" : "";
  }
  return text;
}

void AddFound(FoundOf& sum, const FoundOf& part) { sum.frames += part.frames, sum.found += part.found; }

}  // namespace

void TargetTally::Add(const TargetTally& other) {
  target_frames += other.target_frames, rendered += other.rendered;
  swapped += other.swapped, swapped_tracked += other.swapped_tracked;
  wrong_rendered += other.wrong_rendered;
  off_tracked += other.off_tracked, off_recovered += other.off_recovered,
      off_predicted += other.off_predicted;
  AddFound(any, other.any), AddFound(four, other.four), AddFound(three, other.three),
      AddFound(two_locked, other.two_locked);
  beyond_reacquisition += other.beyond_reacquisition;
  // What is wrong stands before what is lost.
  findings.insert(findings.end(), other.findings.begin(), other.findings.end());
  std::stable_partition(findings.begin(), findings.end(),
                        [](const std::string& text) { return text.find(kLostWord) == std::string::npos; });
  if (findings.size() > kFindingsMax) findings.resize(kFindingsMax);
}

TargetCounter::TargetCounter(const Episode& episode, std::string label)
    : episode_(episode),
      label_(std::move(label)),
      had_(episode.GetWorld().GetScene().targets.size(), false),
      lost_clear_(had_.size(), 0) {}

void TargetCounter::Note(std::uint64_t trigger, const std::string& what, const stereo::TargetPoints& reported,
                         const sim::TargetTruth& own, const Judgement& judgement) {
  std::size_t& noted = reported.status == stereo::FixStatus::kLost ? lost_noted_ : wrong_noted_;
  if (++noted > (&noted == &lost_noted_ ? kLostMax : kWrongMax)) return;
  std::ostringstream text;
  text << label_ << " trigger " << trigger << " "
       << episode_.GetWorld().GetScene().targets[own.target].target.name << ": " << what << std::fixed
       << std::setprecision(1) << " at " << own.epicenter_m.norm() << " m, LEDs " << ViewsOf(own);
  if (reported.status == stereo::FixStatus::kLost)
    text << ", reason: " << ReasonName(reported.reason);
  else
    text << ", off by " << judgement.error_m * 1e3 << " mm, stated "
         << std::sqrt(reported.epicenter_covariance_m2.trace()) * 1e3 << " mm, status "
         << static_cast<int>(reported.status) << ", rebuilt " << static_cast<int>(reported.recovered_mask);
  tally_.findings.push_back(text.str());
}

void TargetCounter::CountOne(std::uint64_t trigger, const stereo::TargetPoints& reported,
                             const sim::TargetTruth& own, const Judgement& judgement) {
  ++tally_.target_frames;
  if (episode_.GetImaging() == Imaging::kRendered) ++tally_.rendered;
  const bool wrong = judgement.outcome == Outcome::kSwapped || judgement.outcome == Outcome::kOff;
  if (wrong && episode_.GetImaging() == Imaging::kRendered) ++tally_.wrong_rendered;
  if (judgement.outcome == Outcome::kSwapped) {
    ++tally_.swapped;
    if (reported.status == stereo::FixStatus::kTracked) ++tally_.swapped_tracked;
    Note(trigger, "wrong name", reported, own, judgement);
  } else if (judgement.outcome == Outcome::kOff) {
    switch (reported.status) {
      case stereo::FixStatus::kTracked:
        ++tally_.off_tracked;
        break;
      case stereo::FixStatus::kRecovered:
        ++tally_.off_recovered;
        break;
      default:
        ++tally_.off_predicted;
    }
    Note(trigger, "wrong place", reported, own, judgement);
  }
  const bool measured =
      judgement.outcome == Outcome::kFound && reported.status != stereo::FixStatus::kPredicted;
  const int visible = own.Visible();
  const auto count = [measured](FoundOf& of) { ++of.frames, of.found += measured ? 1 : 0; };
  count(tally_.any);
  if (visible == 4) count(tally_.four);
  if (visible == 3) count(tally_.three);
  if (visible == 2 && had_[own.target]) count(tally_.two_locked);
  if (visible == 4 && judgement.outcome == Outcome::kLost) Note(trigger, kLostWord, reported, own, judgement);
  int& lost = lost_clear_[own.target];
  lost = visible == 4 && !measured ? lost + 1 : 0;
  if (lost == kReacquiredWithin + 1) ++tally_.beyond_reacquisition;
  had_[own.target] = measured;
}

void TargetCounter::Count(std::uint64_t trigger, const pipeline::PairResult& result) {
  const auto truths = episode_.GetWorld().TruthAt(trigger);
  for (const sim::TargetTruth& own : truths) {
    const stereo::TargetPoints& reported = result.fixes.targets[own.target].state.points;
    CountOne(trigger, reported, own, Judge(reported, own, truths));
  }
}

TargetTally CountEpisode(Episode& episode, std::size_t frames, const std::string& label) {
  TargetCounter counter(episode, label);
  for (std::size_t trigger = 0; trigger < frames; ++trigger) counter.Count(trigger, episode.Expose(trigger));
  return counter.Take();
}

}  // namespace adit::host
