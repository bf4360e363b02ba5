#include "drivers/aravis/frame_clock.h"

#include <cstdint>

#include "drivers/aravis/features.h"

#include <CppUTest/TestHarness.h>

using adit::aravis::ClockMap;
using adit::aravis::FrameCounter;

TEST_GROUP(FrameCounter) {
  FrameCounter counter;
  std::uint64_t missed = 0;
  std::uint64_t Count(std::uint64_t id) { return counter.Count(id, missed); }
};

TEST(FrameCounter, CountsUpFromTheFirstId) {
  LONGS_EQUAL(0, Count(65401));
  LONGS_EQUAL(1, Count(65402));
  LONGS_EQUAL(0, missed);
}

TEST(FrameCounter, GoesOnOverTheWrapWhereZeroIsNeverUsed) {
  Count(65534);
  LONGS_EQUAL(1, Count(65535));
  LONGS_EQUAL(2, Count(1));
  LONGS_EQUAL(0, missed);
  LONGS_EQUAL(3, Count(2));
}

TEST(FrameCounter, SkipsWhatWasLostAlsoOverTheWrap) {
  Count(10);
  LONGS_EQUAL(3, Count(13));
  LONGS_EQUAL(2, missed);
  FrameCounter other;
  other.Count(65533, missed);
  LONGS_EQUAL(4, other.Count(2, missed));
  LONGS_EQUAL(3, missed);
}

TEST(FrameCounter, SixtyFourBitIdsDoNotWrap) {
  Count(65535);
  LONGS_EQUAL(1, Count(65536));
  LONGS_EQUAL(0, missed);
}

TEST(FrameCounter, AnIdThatFallsBackCountsAsTheNextFrame) {
  Count(500);
  LONGS_EQUAL(1, Count(1));
  LONGS_EQUAL(0, missed);
}

TEST(FrameCounter, GrowsOnAfterARestart) {
  Count(7);
  Count(9);
  counter.Restart();
  LONGS_EQUAL(3, Count(1));
  LONGS_EQUAL(0, missed);
}

TEST_GROUP(ClockMap) { ClockMap map; };

TEST(ClockMap, TakesTheShortestDelay) {
  constexpr std::int64_t kOffsetNs = 1'000'000'000'000;
  // Delays of 3, 1 and 5 ms.
  map.ToBox(0, kOffsetNs + 3'000'000);
  CHECK_EQUAL(16'000'000 + kOffsetNs + 1'000'000, map.ToBox(16'000'000, 16'000'000 + kOffsetNs + 1'000'000));
  const std::int64_t third_ns = map.ToBox(32'000'000, 32'000'000 + kOffsetNs + 5'000'000);
  CHECK(third_ns >= 32'000'000 + kOffsetNs + 1'000'000);
  CHECK(third_ns <= 32'000'000 + kOffsetNs + 1'000'000 + 3'000);  // 100 ppm of 20 ms
}

TEST(ClockMap, FollowsADriftOf50PpmForAnHour) {
  std::int64_t worst_ns = 0;
  for (std::int64_t second = 0; second < 3600; ++second) {
    const std::int64_t box_ns = second * 1'000'000'000;
    const std::int64_t camera_ns = box_ns - second * 50'000;
    worst_ns = std::max(worst_ns, std::abs(map.ToBox(camera_ns, box_ns + 1'000'000) - (box_ns + 1'000'000)));
  }
  CHECK(worst_ns < 200'000);
}

TEST(ClockMap, BeginsAnewAfterARestart) {
  map.ToBox(0, 5);
  map.Restart();
  CHECK_EQUAL(1005, map.ToBox(1000, 1005));
}

TEST_GROUP(Features){};

TEST(Features, TheFirstKnownNameIsTaken) {
  const auto only = [](const char* wanted) {
    return [wanted](const char* name) { return std::string_view(name) == wanted; };
  };
  STRCMP_EQUAL("ExposureTimeAbs",
               adit::aravis::FirstAvailable(adit::aravis::kExposureNames, only("ExposureTimeAbs"))->name);
  const auto* const raw = adit::aravis::FirstAvailable(adit::aravis::kExposureNames, only("ExposureTimeRaw"));
  CHECK(raw->kind == adit::aravis::ValueKind::kInteger);
  CHECK(adit::aravis::FirstAvailable(adit::aravis::kExposureNames, only("Shutter")) == nullptr);
}

TEST(Features, OnlySlaveAndMasterAreOnTheNetworksTime) {
  CHECK(adit::aravis::PtpStateIsLocked("Slave"));
  CHECK(adit::aravis::PtpStateIsLocked("Master"));
  for (const char* state : {"", "Listening", "Uncalibrated", "Disabled", "Faulty", "slave"}) {
    CHECK_TEXT(!adit::aravis::PtpStateIsLocked(state), state);
  }
}
