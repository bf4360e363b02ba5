#include "host/latency.h"

#include <CppUTest/TestHarness.h>

TEST_GROUP(Latency){};

TEST(Latency, TheTableTellsEveryPartAndWhatIsWrong) {
  adit::publish::HealthReport report;
  report.uptime_s = 60;
  report.state = "TRACK";
  report.latency = {{"packet_to_grab", "last packet -> taken from Aravis", 3600, 0, 30, 90, 400, 512},
                    {"packet_to_bus", "last packet -> handed to the bus", 1200, 2, 310, 800, 900, 1000}};
  const std::string table = adit::host::FormatLatency(report);
  STRCMP_CONTAINS("running, 60 s, TRACK", table.c_str());
  STRCMP_CONTAINS("last packet -> taken from Aravis", table.c_str());
  STRCMP_CONTAINS("310       800       900      1000", table.c_str());
  STRCMP_CONTAINS("2 below zero", table.c_str());
  CHECK(table.find("not granted") == std::string::npos);
  report.realtime = "no real-time priority 50: Operation not permitted";
  STRCMP_CONTAINS("not granted: no real-time priority 50", adit::host::FormatLatency(report).c_str());
}
