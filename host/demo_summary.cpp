#include "host/demo_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/comparison.h"

namespace adit::host {
namespace {

// What must hold, from the project's promise for the demo.
constexpr double kDemoRateHz = 60;
constexpr double kRateShare = 0.99;  // of 60 pairs a second; the run's ends cut a pair or two
constexpr double kDemoTrackedPct = 99;
constexpr double kRmsLimitM = 0.005, kRmsFromM = 20, kRmsToM = 50;
constexpr double kSamePositionM = 0.5;  // CAN and Modbus are read an epoch apart, and the loader moves

template <class... Values>
std::string Figure(const char* format, Values... values) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

struct Rows {
  std::vector<pipeline::TrackRow> track;
  std::vector<sim::TruthRow> truth;
};

/// The truth between the first and the last pair of the track: before and after, the daemon did not run.
base::Result<Rows> ReadRows(DemoStage& stage) {
  auto track = pipeline::LoadTrack(stage.Path("track.csv"));
  if (!track) return track.error();
  auto truth = sim::ReadTruth(stage.Path("truth.csv"));
  if (!truth) return truth.error();
  if (track->empty()) return base::Error{base::ErrorCode::kFailed, stage.Path("track.csv"), "has no rows"};
  const auto [first, last] = std::minmax_element(
      track->begin(), track->end(), [](const pipeline::TrackRow& a, const pipeline::TrackRow& b) {
        return a.timestamp_ns < b.timestamp_ns;
      });
  std::erase_if(*truth, [from = first->timestamp_ns, to = last->timestamp_ns](const sim::TruthRow& point) {
    return point.mid_exposure_ns < from - base::kNsPerMs || point.mid_exposure_ns > to + base::kNsPerMs;
  });
  return Rows{std::move(*track), std::move(*truth)};
}

/// rms and largest error of four-LED positions over all targets at distances from..to.
struct Errors {
  std::size_t count = 0;
  double sum_m2 = 0, max_m = 0;
  double RmsMm() const { return count == 0 ? 0 : 1000 * std::sqrt(sum_m2 / static_cast<double>(count)); }
};

Errors ErrorsBetween(const Comparison& comparison, double from_m, double to_m) {
  Errors errors;
  for (const Figures& figures : comparison.figures) {
    const bool all_distances = figures.from_m == 0 && figures.to_m > 100;
    if (all_distances || figures.from_m < from_m || figures.to_m > to_m || figures.tracked == 0) continue;
    errors.count += figures.tracked;
    errors.sum_m2 += figures.rms_m * figures.rms_m * static_cast<double>(figures.tracked);
    errors.max_m = std::max(errors.max_m, figures.max_m);
  }
  return errors;
}

void AddTracking(const Comparison& comparison, std::vector<DemoFinding>& findings) {
  std::size_t visible = 0, tracked = 0;
  for (const Figures& figures : comparison.figures) {
    const bool all_distances = figures.from_m == 0 && figures.to_m > 100;
    if (!all_distances) continue;
    visible += figures.visible;
    tracked += figures.tracked;
  }
  const double pct = visible == 0 ? 0 : 100.0 * static_cast<double>(tracked) / static_cast<double>(visible);
  findings.push_back(
      {"tracked of visible", Figure("%.2f %% of %zu", pct, visible), ">= 99 %", pct >= kDemoTrackedPct});
  findings.push_back(
      {"false positions", Figure("%zu", comparison.false_positions), "0", comparison.false_positions == 0});
  const Errors near = ErrorsBetween(comparison, kRmsFromM, kRmsToM);
  findings.push_back({"error against truth, 20-50 m",
                      Figure("rms %.2f mm, max %.2f mm (%zu)", near.RmsMm(), 1000 * near.max_m, near.count),
                      "rms < 5 mm", near.count > 0 && near.RmsMm() < 1000 * kRmsLimitM});
  const Errors all = ErrorsBetween(comparison, 0, 1000);
  findings.push_back({"error against truth, all",
                      Figure("rms %.2f mm, max %.2f mm (%zu)", all.RmsMm(), 1000 * all.max_m, all.count), "",
                      true});
}

/// Pairs and their rate, from the first to the last in the track log.
DemoFinding PairFinding(const std::vector<pipeline::TrackRow>& track) {
  std::size_t pairs = 1;
  for (std::size_t i = 1; i < track.size(); ++i)
    pairs += track[i].timestamp_ns != track[i - 1].timestamp_ns ? 1 : 0;
  const double span_s = static_cast<double>(track.back().timestamp_ns - track.front().timestamp_ns) /
                        static_cast<double>(base::kNsPerS);
  const double rate_hz = span_s > 0 ? static_cast<double>(pairs - 1) / span_s : 0;
  return {"pairs", Figure("%zu in %.1f s, %.2f /s", pairs, span_s, rate_hz), ">= 59.4 /s",
          rate_hz >= kRateShare * kDemoRateHz};
}

/// Names the counters of what was lost: where it went wrong is in which of them rose.
DemoFinding LostFinding(const StatusWords& status) {
  double lost = 0;
  std::string where;
  const auto add = [&](const std::string& key) {
    const double count = NumberOf(status, key);
    lost += count;
    if (count > 0) where += (where.empty() ? ": " : ", ") + key + Figure(" %.0f", count);
  };
  add("unpaired");
  add("log_dropped");
  for (const char* side : {"left.", "right."}) {
    for (const char* count : {"missed", "incomplete", "shed"}) add(std::string(side) + count);
  }
  return {"images lost", Figure("%.0f", lost) + where, "0", lost == 0};
}

void AddFlow(const StatusWords& status, const DemoRun& run, std::vector<DemoFinding>& findings) {
  findings.push_back(LostFinding(status));
  const auto latency = [&](const char* what, const char* key) {
    findings.push_back(
        {what, Figure("p50 %.2f ms, p99 %.2f ms", NumberOf(status, key, 0), NumberOf(status, key, 1)), "",
         true});
  };
  latency("latency, trigger to result", "trigger_to_result_ms");
  latency("latency, last packet to result", "packet_to_result_ms");
  latency("latency, last packet to bus", "packet_to_bus_ms");
  latency("  of it until taken from Aravis", "packet_to_grab_ms");
  findings.push_back(
      {"processor", Figure("aditd %.2f cores, cameras %.2f", run.daemon_cores, run.camera_cores), "", true});
}

void AddWire(DemoStage& stage, const DemoRun& run, std::vector<DemoFinding>& findings) {
  publish::ReceiverCounts sum;
  std::uint64_t bad_lines = 0;
  for (BusReader& bus : stage.Bus()) {
    const publish::ReceiverCounts& counts = bus.Receiver().Counts();
    sum.frames += counts.frames, sum.crc_errors += counts.crc_errors, sum.accepted += counts.accepted;
    bad_lines += bus.BadLines();
  }
  findings.push_back({"CAN frames, CRC verified",
                      Figure("%llu, %llu wrong; %llu epochs accepted",
                             static_cast<unsigned long long>(sum.frames - sum.crc_errors),
                             static_cast<unsigned long long>(sum.crc_errors + bad_lines),
                             static_cast<unsigned long long>(sum.accepted)),
                      "some, 0 wrong",
                      sum.frames > 0 && sum.crc_errors + bad_lines == 0 && sum.accepted > 0});
  if (!run.modbus_position_m || !run.bus_position_m) {
    findings.push_back({"Modbus position", "none read", "as on CAN", false});
    return;
  }
  const auto& p = *run.modbus_position_m;
  double apart_m = 0;
  for (std::size_t i = 0; i < 3; ++i) apart_m = std::hypot(apart_m, p[i] - (*run.bus_position_m)[i]);
  findings.push_back(
      {"Modbus position",
       Figure("(%.3f, %.3f, %.3f) m, %zu reads, %zu bad", p[0], p[1], p[2], run.modbus_reads, run.modbus_bad),
       "as on CAN", apart_m < kSamePositionM && run.modbus_bad == 0});
}

}  // namespace

base::Result<std::vector<DemoFinding>> Summarise(DemoStage& stage, const DemoRun& run) {
  const auto rows = ReadRows(stage);
  if (!rows) return rows.error();
  constexpr int kAllLeds = 4;
  const auto comparison = Compare(rows->track, rows->truth, kAllLeds);
  if (!comparison) return comparison.error();
  std::vector<DemoFinding> findings;
  findings.push_back(PairFinding(rows->track));
  AddFlow(stage.Status(), run, findings);
  AddTracking(*comparison, findings);
  AddWire(stage, run, findings);
  return findings;
}

std::string FormatFindings(const std::vector<DemoFinding>& findings) {
  std::string text = "\nsummary\n";
  for (const DemoFinding& finding : findings) {
    const char* const verdict = finding.wanted.empty() ? "" : finding.good ? "good" : "NOT GOOD";
    text += Figure("  %-32s %-44s %-14s %s\n", finding.what.c_str(), finding.figure.c_str(),
                   finding.wanted.c_str(), verdict);
  }
  return text;
}

bool AllGood(const std::vector<DemoFinding>& findings) {
  return std::all_of(findings.begin(), findings.end(),
                     [](const DemoFinding& finding) { return finding.good; });
}

}  // namespace adit::host
