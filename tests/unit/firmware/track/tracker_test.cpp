#include "firmware/track/tracker.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNever;
using adit::base::Target;
using adit::base::TimeNs;
using adit::stereo::FixStatus;
using adit::stereo::PointSet;
using adit::track::TargetStateSet;
using adit::track::Tracker;

namespace {

Target BarOf(const char* name) { return {name, {0, 0.25, 0.65, 1.5}, -0.5, 0.04}; }

PointSet PairAt(TimeNs mid_exposure_ns, FixStatus first, FixStatus second) {
  PointSet points;
  points.stamp.mid_exposure_ns = mid_exposure_ns;
  points.stamp.last_packet_ns = mid_exposure_ns + 7;
  points.stamp.trigger = 99;
  for (const FixStatus status : {first, second}) {
    adit::stereo::TargetPoints p;
    p.target = static_cast<std::uint8_t>(points.targets.size());
    p.status = status;
    if (status != FixStatus::kLost) p.epicenter_b_m = {1, 2, 30.0 + p.target}, p.direction_b = {1, 0, 0};
    points.targets.push_back(p);
  }
  return points;
}

}  // namespace

TEST_GROUP(Tracker) {
  Tracker tracker{{BarOf("A"), BarOf("B")}};
  TargetStateSet states;
};

TEST(Tracker, DatesEveryMeasurement) {
  tracker.Track(PairAt(1000, FixStatus::kTracked, FixStatus::kTracked), states);
  LONGS_EQUAL(2, states.targets.size());
  const auto& state = states.targets[1];
  CHECK(state.mid_exposure_ns == 1000);
  CHECK(state.last_packet_ns == 1007);
  CHECK(state.trigger == 99);
  CHECK(state.last_seen_ns == 1000);
  DOUBLES_EQUAL(31, state.points.epicenter_b_m.z(), 0);
}

TEST(Tracker, RemembersWhenATargetWasLastSeen) {
  tracker.Track(PairAt(1000, FixStatus::kTracked, FixStatus::kLost), states);
  tracker.Track(PairAt(2000, FixStatus::kLost, FixStatus::kTracked), states);
  tracker.Track(PairAt(3000, FixStatus::kLost, FixStatus::kLost), states);
  CHECK(states.targets[0].last_seen_ns == 1000);
  CHECK(states.targets[1].last_seen_ns == 2000);
  CHECK(states.targets[0].mid_exposure_ns == 3000);
  CHECK(states.targets[0].points.status == FixStatus::kLost);
}

TEST(Tracker, ARecoveredPlaceOfATargetNeverSeenIsToldAtOnce) {
  tracker.Track(PairAt(1000, FixStatus::kRecovered, FixStatus::kLost), states);
  CHECK(states.targets[0].points.status == FixStatus::kRecovered);
  CHECK(states.targets[0].last_seen_ns == 1000);
}

TEST(Tracker, ARecoveredPlaceOfATargetThatComesBackIsToldWhenTheNextPairConfirmsIt) {
  constexpr TimeNs kLaterNs = 2 * adit::base::kNsPerS;
  tracker.Track(PairAt(1000, FixStatus::kTracked, FixStatus::kLost), states);
  tracker.Track(PairAt(kLaterNs, FixStatus::kRecovered, FixStatus::kLost), states);
  CHECK(states.targets[0].points.status == FixStatus::kLost);
  CHECK(states.targets[0].points.reason == adit::stereo::LossReason::kJump);
  CHECK(states.targets[0].points.epicenter_b_m.isZero());
  CHECK(states.targets[0].last_seen_ns == 1000);
  tracker.Track(PairAt(kLaterNs + 1000, FixStatus::kRecovered, FixStatus::kLost), states);
  CHECK(states.targets[0].points.status == FixStatus::kRecovered);
  CHECK(states.targets[0].last_seen_ns == kLaterNs + 1000);
}

TEST(Tracker, HasNeverSeenWhatWasNeverFound) {
  tracker.Track(PairAt(1000, FixStatus::kLost, FixStatus::kLost), states);
  CHECK(states.targets[0].last_seen_ns == kNever);
}

TEST(Tracker, InventsNoPositionForALostTarget) {
  tracker.Track(PairAt(1000, FixStatus::kTracked, FixStatus::kTracked), states);
  tracker.Track(PairAt(2000, FixStatus::kLost, FixStatus::kTracked), states);
  CHECK(states.targets[0].points.epicenter_b_m.isZero());
}
