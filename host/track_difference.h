// Two tracks of one recording: what differs, target by target.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/pipeline/track_row.h"

namespace adit::host {

/// Figures of one target. "Found" is any status with a position.
struct TargetDifference {
  std::string target;
  std::size_t both = 0;            ///< exposures with a position in both tracks
  std::size_t found = 0;           ///< in B only
  std::size_t lost = 0;            ///< in A only
  std::size_t swapped = 0;         ///< of `both`: B's position is where A has another target
  std::size_t status_changes = 0;  ///< of `both`: another status or other rebuilt LEDs
  std::size_t unpaired = 0;        ///< rows, with a position or not, of exposures that only one track has
  double rms_m = 0, max_m = 0;     ///< of the positions' distances, swapped ones included
};

struct TrackDifference {
  std::vector<TargetDifference> targets;  ///< in order of their names

  /// Nothing found, lost, swapped, unpaired or of another status, and no position farther off than this.
  bool Same(double tolerance_m) const;
};

/// Pairs rows of one target and timestamp. Tracks in which one target stands twice at one time are paired
/// with the first.
TrackDifference CompareTracks(const std::vector<pipeline::TrackRow>& a,
                              const std::vector<pipeline::TrackRow>& b);

/// As a table for people, and as JSON.
std::string FormatDifferenceTable(const TrackDifference& difference);
std::string FormatDifferenceJson(const TrackDifference& difference, double tolerance_m);

}  // namespace adit::host
