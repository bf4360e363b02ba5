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

constexpr double kNsPerMs = base::kNsPerMs, kNsPerUs = base::kNsPerUs;

/// p50 and p99 of a part of the way.
std::string Word(Span span, const LatencyTable& latency) {
  const auto index = static_cast<std::size_t>(span);
  const auto quantile_ms = [&](double quantile) {
    return static_cast<double>(latency.At(index).QuantileNs(quantile)) / kNsPerMs;
  };
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), " %s_ms=%.2f/%.2f", kSpanNames[index].key, quantile_ms(0.50),
                quantile_ms(0.99));
  return text.data();
}

publish::LatencyRow RowOf(std::size_t span, const base::DurationHistogram& histogram) {
  const auto quantile_us = [&](double quantile) {
    return static_cast<double>(histogram.QuantileNs(quantile)) / kNsPerUs;
  };
  return {kSpanNames[span].key, kSpanNames[span].what, histogram.Count(),  histogram.Negative(),
          quantile_us(0.50),    quantile_us(0.99),     quantile_us(0.999), quantile_us(1)};
}

/// Frames = shed + shed blob sets + pairs + unpaired + at the ends + what is on its way.
void AddLane(const std::string& side, const LaneHealth& lane, const LoneImages& lone,
             std::vector<publish::HealthCounter>& counters) {
  const auto add = [&](const char* name, std::uint64_t count) {
    counters.push_back({side + "." + name, count});
  };
  add("frames", lane.frames);
  add("incomplete", lane.camera.incomplete);
  add("missed", lane.camera.missed);
  add("starved", lane.camera.starved);
  add("resent", lane.camera.resent);
  add("reconnects", lane.camera.reconnects);
  add("shed_frames", lane.shed_frames);
  add("shed_blob_sets", lane.shed_blob_sets);
  add("unpaired", lone.unpaired);
  add("at_ends", lone.at_ends);
}

std::string LaneWords(const char* side, const LaneHealth& lane) {
  const std::string prefix = side;
  return Word((prefix + ".frames").c_str(), lane.frames) +
         Word((prefix + ".missed").c_str(), lane.camera.missed) +
         Word((prefix + ".incomplete").c_str(), lane.camera.incomplete) +
         Word((prefix + ".shed").c_str(), lane.Shed()) +
         Word((prefix + ".starved").c_str(), lane.camera.starved) +
         Word((prefix + ".reconnects").c_str(), lane.camera.reconnects) +
         (lane.gone ? " " + prefix + ".gone" : "");
}

}  // namespace

std::string FormatStatus(const Status& status) {
  std::array<char, 16> faults{};
  std::snprintf(faults.data(), faults.size(), "0x%04X", status.publish.faults);
  std::string line = "status" + Word("uptime_s", status.uptime_s, 1) +
                     " state=" + StateName(status.publish.state) + " faults=" + faults.data() +
                     Word("rate_hz", status.rate_hz, 1) + Word("pairs", status.pairs.pairs) +
                     Word("unpaired", status.pairs.Unpaired()) +
                     Word("target_pairs", status.pairs.target_pairs) + Word("located", status.pairs.located) +
                     LaneWords("left", status.left) + LaneWords("right", status.right);
  for (const Span span : {Span::kPacketToGrab, Span::kDetect, Span::kLocate, Span::kTriggerToResult,
                          Span::kPacketToResult, Span::kPacketToBus, Span::kExposureToBus}) {
    line += Word(span, *status.latency);
  }
  return line + Word("epochs", status.publish.epochs) + Word("valid", status.publish.valid) +
         Word("can_frames", status.bus.sent_frames) + Word("can_dropped", status.bus.dropped_epochs) +
         Word("modbus_clients", status.modbus_clients) + Word("log_dropped", status.pairs.log_dropped);
}

publish::HealthReport ReportOf(const Status& status, base::TimeNs now_ns, const std::string& realtime) {
  publish::HealthReport report;
  report.written_ns = now_ns;
  report.running = status.running;
  report.uptime_s = status.uptime_s;
  report.state = StateName(status.publish.state);
  report.realtime = realtime;
  report.counters = {{"pairs", status.pairs.pairs},
                     {"target_pairs", status.pairs.target_pairs},
                     {"located", status.pairs.located},
                     {"log_dropped", status.pairs.log_dropped}};
  AddLane("left", status.left, status.pairs.lone[0], report.counters);
  AddLane("right", status.right, status.pairs.lone[1], report.counters);
  report.counters.push_back({"epochs", status.publish.epochs});
  report.counters.push_back({"valid_epochs", status.publish.valid});
  report.counters.push_back({"faults", status.publish.faults});
  report.counters.push_back({"can_frames", status.bus.sent_frames});
  report.counters.push_back({"can_dropped_epochs", status.bus.dropped_epochs});
  report.counters.push_back({"modbus_clients", status.modbus_clients});
  if (status.finding) report.calibration = HealthOf(*status.finding, status.calibration_id);
  for (std::size_t span = 0; span < kSpans; ++span)
    report.latency.push_back(RowOf(span, status.latency->At(span)));
  return report;
}

}  // namespace adit::app
