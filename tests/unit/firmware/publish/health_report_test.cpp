#include "firmware/publish/health_report.h"

#include <cstdio>
#include <fstream>

#include <CppUTest/TestHarness.h>

using adit::publish::FormatHealthReport;
using adit::publish::HealthReport;
using adit::publish::LoadHealthReport;

namespace {

const char* const kPath = "health_report_test.tmp.yaml";

HealthReport Example() {
  HealthReport report;
  report.written_ns = 1'700'000'000'123'000'000;
  report.running = false;
  report.uptime_s = 12.5;
  report.state = "TRACK";
  report.realtime = "no real-time priority 50: \"Operation\" not permitted";
  report.counters = {{"pairs", 36'000}, {"left.frames", 36'001}};
  report.latency = {{"packet_to_bus", "last packet -> handed to the bus", 12, 1, 310.5, 800, 1200.25, 4000}};
  return report;
}

}  // namespace

TEST_GROUP(HealthReport){void Write(const std::string& text){std::ofstream(kPath) << text;
}
void teardown() override { std::remove(kPath); }
}
;

TEST(HealthReport, ReadsBackAsItWasWritten) {
  const HealthReport report = Example();
  Write(FormatHealthReport(report));
  const auto read = LoadHealthReport(kPath);
  CHECK(!!read);
  CHECK(std::abs(read->written_ns - report.written_ns) < adit::base::kNsPerMs);
  CHECK_FALSE(read->running);
  STRCMP_EQUAL(report.state.c_str(), read->state.c_str());
  STRCMP_EQUAL(report.realtime.c_str(), read->realtime.c_str());
  LONGS_EQUAL(2, read->counters.size());
  STRCMP_EQUAL("left.frames", read->counters[1].name.c_str());
  LONGS_EQUAL(36'001, read->counters[1].count);
  LONGS_EQUAL(1, read->latency.size());
  STRCMP_EQUAL("packet_to_bus", read->latency[0].span.c_str());
  STRCMP_EQUAL("last packet -> handed to the bus", read->latency[0].what.c_str());
  LONGS_EQUAL(12, read->latency[0].count);
  LONGS_EQUAL(1, read->latency[0].negative);
  DOUBLES_EQUAL(310.5, read->latency[0].p50_us, 0.05);
  DOUBLES_EQUAL(1200.25, read->latency[0].p999_us, 0.05);
  DOUBLES_EQUAL(4000, read->latency[0].max_us, 0.05);
  CHECK(!read->calibration);
}

TEST(HealthReport, CarriesWhatTheWatchFound) {
  HealthReport report = Example();
  report.calibration = {"9a\"b", "changed", 512.25, {0.5, -12.34, 3}, {0.25, 1.5, 0.75}};
  Write(FormatHealthReport(report));
  const auto read = LoadHealthReport(kPath);
  CHECK(read && read->calibration);
  STRCMP_EQUAL("9a\"b", read->calibration->calibration_id.c_str());
  STRCMP_EQUAL("changed", read->calibration->verdict.c_str());
  DOUBLES_EQUAL(512.25, read->calibration->tracked_s, 0.051);
  for (std::size_t i = 0; i < 3; ++i) {
    DOUBLES_EQUAL(report.calibration->turn_urad[i], read->calibration->turn_urad[i], 0.005);
    DOUBLES_EQUAL(report.calibration->sigma_urad[i], read->calibration->sigma_urad[i], 0.005);
  }
}

TEST(HealthReport, DeclinesWhatIsNoReportWithFileAndKey) {
  const auto absent = LoadHealthReport(kPath);
  CHECK(!absent);
  STRCMP_CONTAINS(kPath, absent.error().Line().c_str());
  Write("rig: rig.yaml\n");
  const auto other = LoadHealthReport(kPath);
  CHECK(!other);
  STRCMP_CONTAINS("written_s", other.error().Line().c_str());
  std::string text = FormatHealthReport(Example());
  text.replace(text.find("count: 12"), 9, "count: -2");
  Write(text);
  const auto negative = LoadHealthReport(kPath);
  CHECK(!negative);
  STRCMP_CONTAINS("count", negative.error().Line().c_str());
  HealthReport watched = Example();
  watched.calibration = {"id", "perhaps", 1, {}, {}};
  Write(FormatHealthReport(watched));
  const auto unknown = LoadHealthReport(kPath);
  CHECK(!unknown);
  STRCMP_CONTAINS("calibration.verdict", unknown.error().Line().c_str());
}
