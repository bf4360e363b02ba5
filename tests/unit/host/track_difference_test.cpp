#include "host/track_difference.h"

#include <cmath>

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CompareTracks;
using adit::host::TargetDifference;
using adit::pipeline::TrackRow;
using adit::stereo::FixStatus;
using Eigen::Vector3d;

TrackRow Row(int frame, const std::string& target, const Vector3d& position_m) {
  TrackRow row;
  row.timestamp_ns = frame * 16'666'667LL;
  row.target = target;
  row.status = FixStatus::kTracked;
  row.position_m = position_m;
  return row;
}

TrackRow Lost(int frame, const std::string& target) {
  TrackRow row;
  row.timestamp_ns = frame * 16'666'667LL;
  row.target = target;
  return row;
}

}  // namespace

TEST_GROUP(TrackDifference){};

TEST(TrackDifference, EqualTracksAreTheSame) {
  const std::vector<TrackRow> track{Row(0, "one", {1, 2, 30}), Lost(0, "two"), Row(1, "one", {1, 2, 31})};
  const auto difference = CompareTracks(track, track);
  CHECK(difference.Same(0));
  LONGS_EQUAL(2, difference.targets.size());
  LONGS_EQUAL(2, difference.targets[0].both);
  LONGS_EQUAL(0, difference.targets[1].both);
}

TEST(TrackDifference, CountsWhatWasFoundAndLost) {
  const std::vector<TrackRow> a{Row(0, "one", {0, 0, 30}), Lost(1, "one"), Lost(2, "one")};
  const std::vector<TrackRow> b{Lost(0, "one"), Row(1, "one", {0, 0, 30}), Row(2, "one", {0, 0, 30})};
  const TargetDifference one = CompareTracks(a, b).targets[0];
  LONGS_EQUAL(2, one.found);
  LONGS_EQUAL(1, one.lost);
  CHECK_FALSE(CompareTracks(a, b).Same(100));
}

TEST(TrackDifference, MeasuresHowFarPositionsAreApart) {
  const std::vector<TrackRow> a{Row(0, "one", {0, 0, 30}), Row(1, "one", {0, 0, 30})};
  const std::vector<TrackRow> b{Row(0, "one", {0.003, 0, 30}), Row(1, "one", {0, 0, 30.004})};
  const auto difference = CompareTracks(a, b);
  DOUBLES_EQUAL(0.004, difference.targets[0].max_m, 1e-12);
  DOUBLES_EQUAL(std::sqrt(12.5e-6), difference.targets[0].rms_m, 1e-12);
  CHECK(difference.Same(0.0041));
  CHECK_FALSE(difference.Same(0.0039));
}

TEST(TrackDifference, KnowsNamesThatChangedPlaces) {
  const std::vector<TrackRow> a{Row(0, "one", {0, 0, 30}), Row(0, "two", {2, 0, 30})};
  const std::vector<TrackRow> b{Row(0, "one", {2, 0, 30}), Row(0, "two", {0, 0, 30})};
  const auto difference = CompareTracks(a, b);
  LONGS_EQUAL(1, difference.targets[0].swapped);
  LONGS_EQUAL(1, difference.targets[1].swapped);
  CHECK_FALSE(difference.Same(10));
}

TEST(TrackDifference, AnotherStatusOrOtherRebuiltLedsDiffer) {
  std::vector<TrackRow> a{Row(0, "one", {0, 0, 30}), Row(1, "one", {0, 0, 30})}, b = a;
  b[0].status = FixStatus::kRecovered, b[0].recovered_mask = 2;
  a[1].status = b[1].status = FixStatus::kRecovered;
  a[1].recovered_mask = 1, b[1].recovered_mask = 4;
  LONGS_EQUAL(2, CompareTracks(a, b).targets[0].status_changes);
  CHECK_FALSE(CompareTracks(a, b).Same(1));
}

TEST(TrackDifference, RowsOfOneTrackAloneDiffer) {
  const std::vector<TrackRow> a{Row(0, "one", {0, 0, 30}), Lost(1, "one")},
      b{Row(0, "one", {0, 0, 30}), Lost(2, "one")};
  LONGS_EQUAL(2, CompareTracks(a, b).targets[0].unpaired);
  CHECK_FALSE(CompareTracks(a, b).Same(1));
  CHECK(CompareTracks({}, {}).Same(0));
}
