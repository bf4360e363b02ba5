// The end of the demo: what was measured, held against what must hold.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/demo_stage.h"

namespace adit::host {

/// What the run itself saw.
struct DemoRun {
  double seconds = 0;  ///< from the first status line on
  double daemon_cores = 0, camera_cores = 0;
  std::size_t modbus_reads = 0, modbus_bad = 0;            ///< live blocks; CRC wrong or torn
  std::optional<std::array<double, 3>> modbus_position_m;  ///< the last one read back
  std::optional<std::array<double, 3>> bus_position_m;     ///< by CAN, at that time
};

/// One line of the summary.
struct DemoFinding {
  std::string what, figure, wanted;
  bool good = true;
};

/// Compares track log and truth (both complete: the stage is stopped), the daemon's last status and the bus.
/// Declines if a file cannot be read.
base::Result<std::vector<DemoFinding>> Summarise(DemoStage& stage, const DemoRun& run);

/// As a table, and whether all is good.
std::string FormatFindings(const std::vector<DemoFinding>& findings);
bool AllGood(const std::vector<DemoFinding>& findings);

}  // namespace adit::host
