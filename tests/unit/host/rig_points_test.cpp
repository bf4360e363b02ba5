#include "host/rig_points.h"

#include <cmath>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::AverageRigPoint;
using adit::host::FindRigPoint;
using adit::pipeline::TrackRow;
using adit::stereo::FixStatus;
using Eigen::Vector3d;

TrackRow Row(const Vector3d& at_m, const std::string& target = "bar") {
  TrackRow row;
  row.target = target;
  row.status = FixStatus::kTracked;
  row.position_m = at_m;
  row.sigma_m = {0.001, 0.001, 0.004};
  for (std::size_t i = 0; i < 4; ++i) row.leds_m[i] = at_m + Vector3d(0.5 * static_cast<double>(i), 0, 0);
  return row;
}

/// `count` rows that jump back and forth by `swing_m`.
std::vector<TrackRow> Swinging(std::size_t count, const Vector3d& swing_m) {
  std::vector<TrackRow> track;
  for (std::size_t i = 0; i < count; ++i)
    track.push_back(Row(Vector3d(1, 2, 40) + (i % 2 == 0 ? 1 : -1) * swing_m));
  return track;
}

}  // namespace

TEST_GROUP(RigPoints){};

TEST(RigPoints, FindsTargetsAndTheirLeds) {
  const std::vector<TrackRow> track{Row({0, 0, 1}), Row({0, 0, 1}, "odd.2")};
  LONGS_EQUAL(0, FindRigPoint(track, "bar")->led);
  LONGS_EQUAL(3, FindRigPoint(track, "bar.3")->led);
  STRCMP_EQUAL("bar.3", FindRigPoint(track, "bar.3")->Text().c_str());
  STRCMP_EQUAL("odd.2", FindRigPoint(track, "odd.2")->target.c_str());
  STRCMP_EQUAL("odd.2.4", FindRigPoint(track, "odd.2.4")->Text().c_str());
  for (const char* name : {"bar.5", "bar.0", "bar.", "bar.33", "ba", "", ".", "odd"})
    CHECK_FALSE(FindRigPoint(track, name).has_value());
}

TEST(RigPoints, AveragesTheReportedPointAndAnLed) {
  const auto track = Swinging(100, {0.0001, 0, 0.002});
  const auto point = *AverageRigPoint(track, {"bar", 0});
  CHECK((point.mean_b_m - Vector3d(1, 2, 40)).norm() < 1e-12);
  LONGS_EQUAL(100, point.rows);
  CHECK((point.sigma_m - Vector3d(0.0001, 0.0001, 0.0004)).norm() < 1e-12);
  CHECK((AverageRigPoint(track, {"bar", 3})->mean_b_m - Vector3d(2, 2, 40)).norm() < 1e-12);
}

TEST(RigPoints, TheScatterCountsWhereItIsLarger) {
  const auto point = *AverageRigPoint(Swinging(100, {0.003, 0, 0}), {"bar", 0});
  DOUBLES_EQUAL(0.003 * std::sqrt(100.0 / 99) / 10, point.sigma_m.x(), 1e-12);
}

TEST(RigPoints, LeavesRebuiltLedsAndLostRowsOut) {
  auto track = Swinging(3, {0, 0, 0});
  track[0].status = FixStatus::kRecovered;
  track[0].recovered_mask = 1U << 1;
  track[0].leds_m[1] = {9, 9, 9};
  track[1].status = FixStatus::kLost;
  track[2].status = FixStatus::kTracked;
  LONGS_EQUAL(1, AverageRigPoint(track, {"bar", 2})->rows);
  LONGS_EQUAL(2, AverageRigPoint(track, {"bar", 0})->rows);
  track[2].status = FixStatus::kPredicted;
  STRCMP_CONTAINS("bar.2: was never measured", AverageRigPoint(track, {"bar", 2}).error().Line().c_str());
}

TEST(RigPoints, RefusesATargetThatMoves) {
  const auto refused = AverageRigPoint(Swinging(20, {0.006, 0, 0}), {"bar", 0});
  CHECK_FALSE(!!refused);
  STRCMP_CONTAINS("does not stand still", refused.error().Line().c_str());
}

TEST(RigPoints, RefusesATrackInTheSiteFrame) {
  const std::vector<TrackRow> track{Row({2600000, 1200000, 431})};
  STRCMP_CONTAINS("rig frame", AverageRigPoint(track, {"bar", 0}).error().Line().c_str());
}
