// What the box says of itself once a second.
#pragma once

#include <optional>
#include <string>

#include "firmware/app/camera_lane.h"
#include "firmware/app/pair_loop.h"
#include "firmware/app/publisher.h"
#include "firmware/publish/health_report.h"

namespace adit::app {

/// Everything a status line tells.
struct Status {
  bool running = true;
  double uptime_s = 0;
  double rate_hz = 0;  ///< pairs a second since the last line
  LaneHealth left, right;
  PairHealth pairs;
  PublishHealth publish;
  std::string calibration_id;             ///< of the rig in use
  std::optional<watch::Finding> finding;  ///< of the watch over the calibration, if there is one
  hal::FieldBusHealth bus;
  std::uint32_t modbus_clients = 0;
  const LatencyTable* latency = nullptr;  ///< of the box; never null in its status
};

/// One line of `key=value` words, for a person and for a program. Latencies in ms, p50/p99.
std::string FormatStatus(const Status& status);

/// The same and more, dated `now_ns`: every counter and every part of the way. `realtime`: what the system
/// refused.
publish::HealthReport ReportOf(const Status& status, base::TimeNs now_ns, const std::string& realtime);

}  // namespace adit::app
