#include "host/latency.h"

#include <array>
#include <cstdio>
#include <memory>

#include "drivers/linux/system_clock.h"
#include "firmware/config/box_config.h"
#include "host/failure.h"

namespace adit::host {
namespace {

// A box writes its report once a second; a busy disk may hold one back as long again.
constexpr base::DurationNs kOldNs = 3 * base::kNsPerS;

/// The report of the box, unless it has become old: then the box has died or hangs.
base::Result<publish::HealthReport> ReadReport(const std::string& box_path) {
  const auto config = config::LoadBoxConfig(box_path);
  if (!config) return config.error();
  if (config->health_report.empty()) {
    return base::Error{base::ErrorCode::kUsage, box_path + ": health_report",
                       "is missing; the box writes no report without it"};
  }
  const std::string path = config->Resolve(config->health_report);
  auto report = publish::LoadHealthReport(path);
  if (!report) return report.error();
  const base::DurationNs age_ns = linux::SystemClock().Now() - report->written_ns;
  if (report->running && age_ns > kOldNs) {
    return base::Error{base::ErrorCode::kUnavailable, path,
                       "is " + std::to_string(age_ns / base::kNsPerS) + " s old; aditd has ended or hangs"};
  }
  return report;
}

int RunLatency(const std::string& box_path) {
  const auto report = ReadReport(box_path);
  if (!report) return Fail("latency", report.error());
  std::cout << FormatLatency(*report);
  return 0;
}

}  // namespace

std::string FormatLatency(const publish::HealthReport& report) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), "%s, %.0f s, %s; in us\n%-70s %10s %9s %9s %9s %9s\n",
                report.running ? "running" : "stopped", report.uptime_s, report.state.c_str(), "", "count",
                "p50", "p99", "p99.9", "max");
  std::string text = line.data();
  for (const publish::LatencyRow& row : report.latency) {
    std::snprintf(line.data(), line.size(), "%-70s %10llu %9.0f %9.0f %9.0f %9.0f", row.what.c_str(),
                  static_cast<unsigned long long>(row.count), row.p50_us, row.p99_us, row.p999_us,
                  row.max_us);
    text += line.data();
    if (row.negative > 0)
      text += "  and " + std::to_string(row.negative) + " below zero: two clocks disagree";
    text += "\n";
  }
  if (!report.realtime.empty()) text += "not granted: " + report.realtime + "\n";
  return text;
}

void AddLatency(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("latency", "where the time goes in a running box");
  auto path = std::make_shared<std::string>();
  command->add_option("BOX", *path, "the box's configuration, with the key health_report")->required();
  command->callback([path, &exit_code] { exit_code = RunLatency(*path); });
}

}  // namespace adit::host
