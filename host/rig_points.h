// Targets and single LEDs that stand still, as the rig measured them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/pipeline/track_row.h"

namespace adit::host {

/// A target's reported point (led 0), or one of its LEDs (1 to 4).
struct RigPointName {
  std::string target;
  int led = 0;

  /// "target" or "target.3"
  std::string Text() const;
};

/// Reads "target" or "target.1" to "target.4". None if no row has such a target. A target whose own name ends
/// so comes first.
std::optional<RigPointName> FindRigPoint(const std::vector<pipeline::TrackRow>& track,
                                         const std::string& name);

/// The mean of all measurements of a point in the rig frame.
struct RigPoint {
  Eigen::Vector3d mean_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< of the mean, one standard deviation
  std::size_t rows = 0;
};

/// Averages the rows of `name` that were measured; an LED that a row rebuilt is left out of it. The sigma is
/// the larger of the rows' own and their scatter, over the root of their number. Declines (kFailed): the
/// point was never measured, it moved (its scatter is above five of its sigmas), or it lies more than 1000 m
/// away, as in a track that is in the site frame already.
base::Result<RigPoint> AverageRigPoint(const std::vector<pipeline::TrackRow>& track,
                                       const RigPointName& name);

}  // namespace adit::host
