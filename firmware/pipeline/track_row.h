// The track CSV: one row per pair and target, written and read.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/base/pose.h"
#include "firmware/base/result.h"
#include "firmware/georef/geo_fix.h"

namespace adit::pipeline {

/// One row. Positions are in the site frame, which is the rig frame without a georeference; metres.
struct TrackRow {
  base::TimeNs timestamp_ns = 0;  ///< mid-exposure
  std::uint64_t trigger = 0;
  std::string target;
  stereo::FixStatus status = stereo::FixStatus::kLost;
  // All zero when lost.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< one standard deviation
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, base::kLedCount> leds_m = base::ZeroPoints<base::kLedCount>();
  std::uint8_t recovered_mask = 0;  ///< bit i: LED i+1 was rebuilt
  double bar_m = 0;
  double reprojection_px = 0;
};

/// The row that says what `fix` says. `name` is the target's.
TrackRow TrackRowOf(const georef::GeoFix& fix, const std::string& name);

/// The header line, without line end.
std::string_view TrackHeader();

/// One line without line end: fixed six decimals (a micrometre), the same on every machine.
std::string FormatTrackRow(const TrackRow& row);

/// Reads one line. Refuses other than 28 fields, numbers that are not finite, a status that is not known, a
/// `recovered` row that names no LED and one that names LEDs without being recovered, a lost row with numbers
/// and any other without. `where` (file and line) is taken into the error.
base::Result<TrackRow> ParseTrackRow(std::string_view line, const std::string& where);

/// Reads a whole text: the header, then rows; a last line without its end is read, CR before LF and empty
/// lines are skipped. `name` is the file's, for errors.
base::Result<std::vector<TrackRow>> ParseTrack(std::string_view text, const std::string& name);

/// Reads a file.
base::Result<std::vector<TrackRow>> LoadTrack(const std::string& path);

}  // namespace adit::pipeline
