// What became of targets whose truth is known, over many frames.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host/episode.h"
#include "host/judgement.h"

namespace adit::host {

/// Frames of a kind, and how many of them had a right position.
struct FoundOf {
  std::size_t frames = 0, found = 0;
  double Pct() const {
    return frames == 0 ? NAN : 100.0 * static_cast<double>(found) / static_cast<double>(frames);
  }
};

/// Counts of target-frames. Addable, so that pieces can be counted apart.
struct TargetTally {
  std::size_t target_frames = 0, rendered = 0;
  std::size_t swapped = 0, swapped_tracked = 0;  ///< of any status; of them those told as tracked
  std::size_t off_tracked = 0;                   ///< reported as tracked
  std::size_t off_recovered = 0;                 ///< with rebuilt LEDs
  std::size_t off_predicted = 0;
  std::size_t wrong_rendered = 0;  ///< of all these, in rendered images
  /// By the number of LEDs that both cameras can measure: unoccluded and 2 px clear of anything else.
  FoundOf four, three;
  FoundOf any;                           ///< all target-frames, whatever can be seen
  FoundOf two_locked;                    ///< two such LEDs, and a position one frame before
  std::size_t beyond_reacquisition = 0;  ///< runs of lost frames with four such LEDs that are longer than two
  std::vector<std::string> findings;     ///< wrong ones, then ones lost with four clear LEDs

  void Add(const TargetTally& other);
};

/// Counts the frames of one episode.
class TargetCounter {
 public:
  explicit TargetCounter(const Episode& episode, std::string label);

  void Count(std::uint64_t trigger, const pipeline::PairResult& result);
  TargetTally Take() { return std::move(tally_); }

 private:
  void CountOne(std::uint64_t trigger, const stereo::TargetPoints& reported, const sim::TargetTruth& own,
                const Judgement& judgement);
  void Note(std::uint64_t trigger, const std::string& what, const stereo::TargetPoints& reported,
            const sim::TargetTruth& own, const Judgement& judgement);

  const Episode& episode_;
  std::string label_;
  std::vector<bool> had_;        ///< a position in the frame before
  std::vector<int> lost_clear_;  ///< frames in a row that were lost with four clear LEDs
  std::size_t wrong_noted_ = 0, lost_noted_ = 0;
  TargetTally tally_;
};

/// The frames 0 to `frames` - 1 of an episode.
TargetTally CountEpisode(Episode& episode, std::size_t frames, const std::string& label);

}  // namespace adit::host
