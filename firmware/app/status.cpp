#include "firmware/app/status.h"

#include <array>
#include <cstdio>

namespace adit::app {
namespace {

const char* StateName(publish::BoxState state) {
  static constexpr std::array<const char*, 8> kNames{"INIT", "SEARCH",  "TRACK", "DEGRADED",
                                                     "LOST", "SERVICE", "FAULT", "SIMULATION"};
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames[index] : "?";
}

std::string Word(const char* key, double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), " %s=%.*f", key, digits, value);
  return text.data();
}

std::string Word(const char* key, std::uint64_t value) {
  return " " + std::string(key) + "=" + std::to_string(value);
}

std::string Words(const char* key, const Quantiles& quantiles) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), " %s=%.2f/%.2f", key, quantiles.p50_ms, quantiles.p99_ms);
  return text.data();
}

std::string LaneWords(const char* side, const LaneHealth& lane) {
  const std::string prefix = side;
  return Word((prefix + ".frames").c_str(), lane.frames) +
         Word((prefix + ".missed").c_str(), lane.camera.missed) +
         Word((prefix + ".incomplete").c_str(), lane.camera.incomplete) +
         Word((prefix + ".shed").c_str(), lane.shed_frames + lane.shed_blob_sets) +
         Word((prefix + ".starved").c_str(), lane.camera.starved) +
         Word((prefix + ".reconnects").c_str(), lane.camera.reconnects) +
         (lane.gone ? " " + prefix + ".gone" : "");
}

}  // namespace

Quantiles QuantilesOf(const base::DurationHistogram& histogram) {
  constexpr double kNsPerMs = base::kNsPerMs;
  return {static_cast<double>(histogram.QuantileNs(0.50)) / kNsPerMs,
          static_cast<double>(histogram.QuantileNs(0.99)) / kNsPerMs};
}

std::string FormatStatus(const Status& status) {
  std::array<char, 16> faults{};
  std::snprintf(faults.data(), faults.size(), "0x%04X", status.publish.faults);
  return "status" + Word("uptime_s", status.uptime_s, 1) + " state=" + StateName(status.publish.state) +
         " faults=" + faults.data() + Word("rate_hz", status.rate_hz, 1) + Word("pairs", status.pairs.pairs) +
         Word("unpaired", status.pairs.unpaired) + Word("target_pairs", status.pairs.target_pairs) +
         Word("located", status.pairs.located) + LaneWords("left", status.left) +
         LaneWords("right", status.right) + Words("detect_ms", status.detect) +
         Words("locate_ms", status.locate) + Words("trigger_to_result_ms", status.trigger_to_result) +
         Words("packet_to_result_ms", status.packet_to_result) +
         Words("packet_to_bus_ms", status.packet_to_bus) + Word("epochs", status.publish.epochs) +
         Word("valid", status.publish.valid) + Word("can_frames", status.bus.sent_frames) +
         Word("can_dropped", status.bus.dropped_epochs) + Word("modbus_clients", status.modbus_clients) +
         Word("log_dropped", status.pairs.log_dropped);
}

}  // namespace adit::app
