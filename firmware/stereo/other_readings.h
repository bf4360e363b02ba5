// What else the lights may be that pass for a bar's LEDs.
#pragma once

#include <bitset>
#include <vector>

#include "firmware/stereo/bar_builder.h"

namespace adit::stereo {

/// Two LEDs of one gap can be read from either end, and a lamp on the bar's line completes the wrong reading
/// as well as a third LED completes the right one, or better, if that has merged with another lamp. So an LED
/// that is seen and one that a light hides count alike, and readings that leave as little unaccounted for are
/// ambiguous. One thread; no allocation after construction.
class OtherReadings {
 public:
  OtherReadings(const optics::Rig& rig, const std::vector<base::Target>& targets,
                const LocatorOptions& options)
      : targets_(targets), rig_(rig), views_(MakeViews(rig)), options_(options) {}

  /// A bar of target `target`, and the targets that its lights may be part of.
  struct Question {
    const Solution* bar = nullptr;
    std::size_t target = 0;
    std::bitset<identify::kMaxTargets> rivals;
  };
  /// Whether two of the bar's lights, taken for other LEDs, are a bar, of its target or of a rival, that is
  /// not worse by `options.chi_square_margin`. `builder` has the pair set.
  bool Exist(const Question& question, const BarBuilder& builder) const;

 private:
  /// Two lights of the bar and what they stand for in it: LED indices, first < last.
  struct Two {
    std::size_t first = 0, last = 0;
    LocatedPoint at_first, at_last;
  };

  bool MayBeOthers(const Question& question, const Two& two, const BarBuilder& builder) const;
  double Unexplained(const base::Target& target, const Solution& bar, const BarBuilder& builder) const;
  std::optional<LocatedPoint> Locate(const Solution& bar, std::size_t led, const BarBuilder& builder) const;

  std::vector<base::Target> targets_;
  optics::Rig rig_;
  Views views_;
  LocatorOptions options_;
};

}  // namespace adit::stereo
