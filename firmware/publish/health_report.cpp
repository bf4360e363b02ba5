#include "firmware/publish/health_report.h"

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
  if (auto done = in->Finish(); !done) return done.error();
  return report;
}

}  // namespace adit::publish
