// What the box says of itself once a second.
#pragma once

#include <optional>
#include <string>

#include "firmware/app/camera_lane.h"
#include "firmware/app/pair_loop.h"
#include "firmware/app/publisher.h"

namespace adit::app {

/// p50 and p99, for people.
struct Quantiles {
  double p50_ms = 0, p99_ms = 0;
};
Quantiles QuantilesOf(const base::DurationHistogram& histogram);

/// Everything a status line tells.
struct Status {
  double uptime_s = 0;
  double rate_hz = 0;  ///< pairs a second since the last line
  LaneHealth left, right;
  PairHealth pairs;
  PublishHealth publish;
  std::optional<watch::Finding> finding;  ///< of the watch over the calibration, if there is one
  hal::FieldBusHealth bus;
  std::uint32_t modbus_clients = 0;
  Quantiles detect, locate, trigger_to_result, packet_to_result, packet_to_bus;
};

/// One line of `key=value` words, for a person and for a program. Latencies in ms.
std::string FormatStatus(const Status& status);

}  // namespace adit::app
