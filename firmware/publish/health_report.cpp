#include "firmware/publish/health_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"

namespace adit::publish {
namespace {

constexpr base::Range kNotNegative{0, 1e15};
constexpr double kNsPerS = base::kNsPerS;

std::uint64_t Count(base::YamlReader& in, const std::string& key) {
  return static_cast<std::uint64_t>(in.Integer(key, kNotNegative));
}

LatencyRow ReadRow(base::YamlReader& in) {
  LatencyRow row;
  row.span = in.Text("span");
  row.what = in.Text("what");
  row.count = Count(in, "count");
  row.negative = Count(in, "negative");
  row.p50_us = in.Number("p50_us", kNotNegative);
  row.p99_us = in.Number("p99_us", kNotNegative);
  row.p999_us = in.Number("p999_us", kNotNegative);
  row.max_us = in.Number("max_us", kNotNegative);
  return row;
}

CalibrationHealth ReadCalibration(base::YamlReader in) {
  static constexpr base::Range kAngle{-1e6, 1e6};
  CalibrationHealth calibration;
  calibration.calibration_id = in.Text("id");
  calibration.verdict = in.Choice("verdict", {"learning", "holds", "changed"});
  calibration.tracked_s = in.Number("tracked_s", kNotNegative);
  const auto angles = [&in](const char* key, std::array<double, 3>& urad) {
    const std::vector<double> read = in.Numbers(key, urad.size(), kAngle);
    if (read.size() == urad.size()) std::copy(read.begin(), read.end(), urad.begin());
  };
  angles("turn_urad", calibration.turn_urad);
  angles("sigma_urad", calibration.sigma_urad);
  return calibration;
}

std::string FormatCalibration(const CalibrationHealth& calibration) {
  std::ostringstream text;
  const auto angles = [](const std::array<double, 3>& urad) {
    std::ostringstream list;
    list << std::fixed << std::setprecision(2) << "[" << urad[0] << ", " << urad[1] << ", " << urad[2] << "]";
    return list.str();
  };
  text << std::fixed << std::setprecision(1)
       << "calibration:\n  id: " << base::Quoted(calibration.calibration_id)
       << "\n  verdict: " << calibration.verdict << "\n  tracked_s: " << calibration.tracked_s
       << "\n  turn_urad: " << angles(calibration.turn_urad)
       << "\n  sigma_urad: " << angles(calibration.sigma_urad) << "\n";
  return text.str();
}

}  // namespace

std::string FormatHealthReport(const HealthReport& report) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  text << "# A box of adit; `adit latency` prints it as a table.\nwritten_s: " << std::setprecision(3)
       << static_cast<double>(report.written_ns) / kNsPerS << std::setprecision(1)
       << "\nrunning: " << (report.running ? "true" : "false") << "\nuptime_s: " << report.uptime_s
       << "\nstate: " << base::Quoted(report.state) << "\n";
  if (!report.realtime.empty()) text << "realtime: " << base::Quoted(report.realtime) << "\n";
  text << "counters:\n";
  for (const HealthCounter& counter : report.counters)
    text << "  " << counter.name << ": " << counter.count << "\n";
  text << "latency:\n";
  for (const LatencyRow& row : report.latency) {
    text << "  - {span: " << row.span << ", what: " << base::Quoted(row.what) << ", count: " << row.count
         << ", negative: " << row.negative << ", p50_us: " << row.p50_us << ", p99_us: " << row.p99_us
         << ", p999_us: " << row.p999_us << ", max_us: " << row.max_us << "}\n";
  }
  if (report.calibration) text << FormatCalibration(*report.calibration);
  return text.str();
}

base::Result<HealthReport> LoadHealthReport(const std::string& path) {
  auto in = base::YamlReader::OpenFile(path);
  if (!in) return in.error();
  HealthReport report;
  report.written_ns = std::llround(in->Number("written_s", {0, 9e9}) * kNsPerS);
  report.running = in->BoolOr("running", false);
  report.uptime_s = in->Number("uptime_s", kNotNegative);
  report.state = in->Text("state");
  report.realtime = in->TextOr("realtime", "");
  base::YamlReader counters = in->Child("counters");
  for (const std::string& name : counters.Keys()) report.counters.push_back({name, Count(counters, name)});
  for (base::YamlReader& row : in->Items("latency")) report.latency.push_back(ReadRow(row));
  if (in->Has("calibration")) report.calibration = ReadCalibration(in->Child("calibration"));
  if (auto done = in->Finish(); !done) return done.error();
  return report;
}

}  // namespace adit::publish
