// Tables 5.1 to 5.6 of the seed, measured again in simulation.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/report_page.h"

namespace adit::host {

/// One figure of one row.
struct SeedCell {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string key, title;  ///< of the column; mm
  double thesis_mm = kNone, bound_mm = kNone, measured_mm = kNone;
  double limit_mm = kNone;  ///< `measured_mm` must not exceed it; none: informs only
  std::string limit_name;   ///< "1.5 x bound"

  bool Holds() const { return limit_name.empty() || measured_mm <= limit_mm; }
};

struct SeedRow {
  double distance_m = 0;
  std::string setting;  ///< "base 6 m"; empty if the table has one
  std::vector<SeedCell> cells;
};

struct SeedTable {
  std::string number, caption, how;
  std::vector<SeedRow> rows;
  std::size_t frames = 0, lost = 0;

  bool Holds() const;
};

struct SeedOrder {
  std::size_t calibrations = 30;  ///< of each rig
  std::uint64_t seed = 1;
  std::string only;  ///< "5.4"; empty: all
};

/// The names of the tables.
std::vector<std::string> SeedTableNumbers();

/// Measures them. Declines as Calibrate does.
base::Result<std::vector<SeedTable>> MeasureSeedTables(const SeedOrder& order);

/// What every reader must know before any factor is quoted.
std::vector<std::string> SeedCaveats(const SeedOrder& order);

/// For people on a terminal: thesis, bound, measured.
std::string FormatSeedTable(const SeedTable& table);
ReportPage MakeSeedReport(const std::vector<SeedTable>& tables, const SeedOrder& order);

}  // namespace adit::host
