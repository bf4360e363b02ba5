#include "host/bus_reader.h"

#include <cstdio>
#include <fstream>

#include <CppUTest/TestHarness.h>

using adit::host::BusReader;
using adit::host::ParseCandump;

TEST_GROUP(BusReader) {
  const char* const path = "bus_reader_test.tmp.log";
  void setup() override { std::remove(path); }
  void teardown() override { std::remove(path); }
  void Append(const char* text) { std::ofstream(path, std::ios::app) << text; }
};

TEST(BusReader, ReadsALineOfCandump) {
  const auto logged = ParseCandump("(1700000000.050199) can0 1A0#D8EAA0131F4EB0FB");
  CHECK(logged.has_value());
  CHECK_EQUAL(1700000000050199000, logged->time_ns);
  LONGS_EQUAL(0x1A0, logged->frame.id);
  CHECK(!logged->frame.extended);
  LONGS_EQUAL(8, logged->frame.length);
  LONGS_EQUAL(0xD8, logged->frame.data[0]);
  LONGS_EQUAL(0xFB, logged->frame.data[7]);
}

TEST(BusReader, ReadsExtendedIdsAndShortFrames) {
  const auto logged = ParseCandump("(0.000001) vcan0 0CFF40C8#0102");
  CHECK(logged.has_value());
  CHECK(logged->frame.extended);
  LONGS_EQUAL(2, logged->frame.length);
}

TEST(BusReader, DeclinesWhatIsNoLine) {
  for (const char* line :
       {"", "(", "hello", "(1.000000) can0", "(1.0) can0 1A0#00", "(1.000000) can0 1A0#0",
        "(1.000000) can0 XYZ#00", "(1.000000) can0 1A0#000000000000000000", "1A0#00 (1.000000) can0 "}) {
    CHECK_TEXT(!ParseCandump(line).has_value(), line);
  }
}

TEST(BusReader, FollowsAFileThatGrowsAndWaitsForTheRestOfALine) {
  BusReader reader(path, 0x20);
  LONGS_EQUAL(0, reader.Follow());
  Append("(1700000000.000000) can0 1A0#87C9EEF64D1749FA\n(1700000000.000300) can0 2A0#00000");
  LONGS_EQUAL(1, reader.Follow());
  Append("08018800FFA\n(1700000000.000301) can0 7FF#00\n");
  LONGS_EQUAL(1, reader.Follow());
  LONGS_EQUAL(0, reader.Follow());
  CHECK_EQUAL(1700000000000300000, reader.LastFrameNs());
  LONGS_EQUAL(0, reader.BadLines());
}

TEST(BusReader, CountsLinesThatAreNone) {
  BusReader reader(path, 0x20);
  Append("garbage\n(1700000000.000000) can0 1A0#87C9EEF64D1749FA\n");
  LONGS_EQUAL(1, reader.Follow());
  LONGS_EQUAL(1, reader.BadLines());
}
