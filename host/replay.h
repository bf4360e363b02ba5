// A recording through the pipeline of the box: the track that it makes.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware/base/result.h"

namespace adit::host {

struct ReplayOrder {
  std::string recording;            ///< folder in EuRoC layout
  std::string rig;                  ///< file
  std::vector<std::string> models;  ///< files
  std::vector<std::string> bodies;  ///< files
  std::string georeference;         ///< file; empty: the track is in the rig frame
  bool filter = false;              ///< states are the filter's, bridged while a lock lasts
};

/// What became of a recording.
struct ReplayedTrack {
  std::string text;  ///< the track file: header and rows
  std::size_t pairs = 0;
  std::vector<std::string> targets;
  std::vector<std::size_t> positions;  ///< of each target and body

  void PrintSummary(std::ostream& out) const;
};

/// Replays pair by pair, with a progress bar. Declines as the loaders of its files, the pipeline and the
/// reader of the recording do.
base::Result<ReplayedTrack> ReplayRecording(const ReplayOrder& order);

}  // namespace adit::host
