// A track against the truth: what was found, how far off it was, and whether it knew.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "drivers/sim/truth_file.h"
#include "firmware/base/result.h"
#include "firmware/pipeline/track_row.h"

namespace adit::host {

/// Figures of one target in one range of distances (from the rig's origin).
struct Figures {
  std::string target;  ///< empty: all targets
  double from_m = 0, to_m = 0;
  std::size_t visible = 0;    ///< truth rows with enough visible LEDs
  std::size_t tracked = 0;    ///< of those, with a position
  std::size_t recovered = 0;  ///< of those, with rebuilt LEDs
  std::size_t hidden = 0;     ///< positions although fewer LEDs were visible; not in the errors
  // Without any position these are NaN: there is no error to tell.
  double rms_m = 0, max_m = 0;
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();  ///< mean of measured minus true
  double nees = 0;        ///< mean of sum (error / sigma)^2 over x, y, z; 3 if the sigmas are true
  double bar_mae_m = 0;   ///< mean absolute error of the measured bar length
  double bar_xrms_m = 0;  ///< half the difference of the true and the rms measured bar length (seed 5.2.2)
  std::size_t flips = 0;  ///< direction against the truth's

  double TrackedPct() const {
    return visible == 0 ? 0 : 100.0 * static_cast<double>(tracked) / static_cast<double>(visible);
  }
};

/// A position and its truth.
struct ComparedRow {
  std::string target;
  Eigen::Vector3d truth_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d error_m = Eigen::Vector3d::Zero();  ///< measured minus true
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< as stated
  double bar_error_m = 0;
};

struct Comparison {
  std::vector<Figures> figures;     ///< per target: all distances, then each range that holds rows
  std::vector<ComparedRow> rows;    ///< those behind the errors, in the order of the truth
  std::size_t false_positions = 0;  ///< positions of targets that the truth does not hold at that time
};

/// Measured rows only: `lost` and `predicted` count as no position. Pairs rows of one target whose times
/// differ by less than 1 ms. Declines (kFailed) when there is nothing to compare: no truth row with
/// `visible_min` LEDs, and no false position either.
base::Result<Comparison> Compare(const std::vector<pipeline::TrackRow>& track,
                                 const std::vector<sim::TruthRow>& truth, int visible_min);

/// As a table for people, and as JSON.
std::string FormatTable(const Comparison& comparison);
std::string FormatJson(const Comparison& comparison);

}  // namespace adit::host
