// What the box says of itself, for people and for programs that watch boxes: counters and latencies.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/base/time.h"

namespace adit::publish {

/// A counter since the start.
struct HealthCounter {
  std::string name;  ///< "left.frames"
  std::uint64_t count = 0;
};

/// How long one part of the way takes, over everything since the start.
struct LatencyRow {
  std::string span;  ///< "packet_to_bus"
  std::string what;  ///< the same in words
  std::uint64_t count = 0;
  std::uint64_t negative = 0;  ///< beside `count`: two clocks disagreed
  double p50_us = 0, p99_us = 0, p999_us = 0, max_us = 0;
};

/// What the watch over the calibration has found in the traffic.
struct CalibrationHealth {
  std::string calibration_id;  ///< of the rig file in use
  std::string verdict;         ///< "learning", "holds" or "changed"
  double tracked_s = 0;        ///< seconds of tracking behind it
  /// The estimated turn of the right camera against that calibration: pitch, yaw, roll, about its own axes.
  std::array<double, 3> turn_urad{}, sigma_urad{};
};

/// A report is a file, replaced as a whole once a second: it needs no protocol and no thread, any tool reads
/// it, and one that has become old says that its box hangs. Not for the hot path.
struct HealthReport {
  base::TimeNs written_ns = base::kNever;  ///< box clock
  bool running = true;                     ///< false: the last report of a box that was stopped
  double uptime_s = 0;
  std::string state;  ///< "TRACK"
  std::string
      realtime;  ///< what the system refused of priorities, affinity and locked memory; empty: nothing
  std::vector<HealthCounter> counters;
  std::vector<LatencyRow> latency;
  std::optional<CalibrationHealth> calibration;  ///< empty: nobody watches
};

/// As YAML that LoadHealthReport reads.
std::string FormatHealthReport(const HealthReport& report);

/// Declines with file and key.
base::Result<HealthReport> LoadHealthReport(const std::string& path);

}  // namespace adit::publish
