// truth.csv: what a simulated recording really shows.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "drivers/sim/world.h"
#include "firmware/base/result.h"
#include "firmware/base/target.h"
#include "firmware/base/time.h"

namespace adit::sim {

/// One row: one target at one trigger, seen or not. The columns are
///   timestamp_ns          middle of the exposure, as in data.csv
///   trigger               counted from 0
///   target                its name
///   x_m, y_m, z_m         the epicenter in the rig frame
///   dx, dy, dz            unit direction from LED 1 to LED 4
///   led1_x_m .. led4_z_m  the LEDs in the rig frame
///   visible               how many LEDs both cameras can measure: on, nothing before them, inside both
///   images
///                         and clear of every other light in both (kClearPx and kDarkDn in world.h say how
///                         that is judged)
struct TruthRow {
  base::TimeNs mid_exposure_ns = 0;
  std::uint64_t trigger = 0;
  std::string target;
  Eigen::Vector3d epicenter_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  std::array<Eigen::Vector3d, base::kLedCount> leds_m{};
  int visible = 0;
};

/// The rows of one trigger, in the scene's order of targets.
std::vector<TruthRow> TruthRows(const World& world, std::uint64_t trigger);

/// The header line, and rows to put below it; lengths to 0.1 um.
std::string TruthHeader();
std::string FormatTruth(const std::vector<TruthRow>& rows);

/// Reads a truth file. Refuses, with file and line: another header, a wrong number of cells, cells that are
/// no numbers, a direction that is no unit vector, `visible` outside 0 to 4, times that go back.
base::Result<std::vector<TruthRow>> ReadTruth(const std::string& path);

}  // namespace adit::sim
