#include "firmware/georef/georeference.h"

#include <CppUTest/TestHarness.h>

using adit::georef::AbsoluteOrientation;
using adit::georef::GeoFixSet;
using adit::georef::Georeference;
using adit::stereo::FixStatus;
using Eigen::Vector3d;

namespace {

/// A rig that looks north along the tunnel: its x is easting, its y is down, its z is northing.
AbsoluteOrientation LookingNorth() {
  AbsoluteOrientation orientation;
  orientation.T_s_b.rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  orientation.T_s_b.translation_m = {546123, 178456, 400};
  return orientation;
}

adit::track::TargetStateSet OneTarget(FixStatus status) {
  adit::track::TargetState state;
  state.points.status = status;
  if (status != FixStatus::kLost) {
    state.points.epicenter_b_m = {3, -1, 40};
    state.points.direction_b = {0, 0, 1};
    state.points.leds_b_m = {Vector3d(3, -1, 40), Vector3d(3, -1, 40.25), Vector3d(3, -1, 40.65),
                             Vector3d(3, -1, 41.5)};
    state.points.epicenter_covariance_m2 = Vector3d(1e-6, 4e-6, 9e-6).asDiagonal();
  }
  state.mid_exposure_ns = 77;
  adit::track::TargetStateSet states;
  states.targets.push_back(state);
  return states;
}

}  // namespace

TEST_GROUP(Georeference) { GeoFixSet fixes; };

TEST(Georeference, TurnsPlaceDirectionAndCovarianceIntoTheGrid) {
  Georeference(LookingNorth()).Apply(OneTarget(FixStatus::kTracked), fixes);
  CHECK(fixes.georeferenced);
  const auto& fix = fixes.targets[0];
  CHECK((fix.position_s_m - Vector3d(546126, 178496, 401)).norm() < 1e-9);
  CHECK((fix.direction_s - Vector3d(0, 1, 0)).norm() < 1e-12);
  CHECK((fix.leds_s_m[3] - Vector3d(546126, 178497.5, 401)).norm() < 1e-9);
  CHECK((fix.covariance_s_m2.diagonal() - Vector3d(1e-6, 9e-6, 4e-6)).norm() < 1e-18);
  CHECK(fix.state.mid_exposure_ns == 77);
}

TEST(Georeference, ShortensTheGridButNotHeights) {
  AbsoluteOrientation orientation = LookingNorth();
  orientation.grid_scale_factor = 0.9996;
  Georeference(orientation).Apply(OneTarget(FixStatus::kTracked), fixes);
  const auto& fix = fixes.targets[0];
  CHECK((fix.position_s_m - Vector3d(546123 + 3 * 0.9996, 178456 + 40 * 0.9996, 401)).norm() < 1e-9);
  DOUBLES_EQUAL(1, fix.direction_s.norm(), 1e-15);
  DOUBLES_EQUAL(9e-6 * 0.9996 * 0.9996, fix.covariance_s_m2(1, 1), 1e-18);
}

TEST(Georeference, AddsWhatTheOrientationDoesNotKnow) {
  AbsoluteOrientation orientation = LookingNorth();
  orientation.reference_b_m = {0, 0, 30};
  // heading 1 mrad; the reference point 1 mm in easting
  orientation.covariance.diagonal() << 0, 0, 1e-6, 1e-6, 0, 0;
  Georeference(orientation).Apply(OneTarget(FixStatus::kTracked), fixes);
  // From the reference point the target is 3 m east and 10 m north.
  const Eigen::Matrix3d& covariance = fixes.targets[0].covariance_s_m2;
  DOUBLES_EQUAL(1e-6 + 1e-6 + 100e-6, covariance(0, 0), 1e-15);
  DOUBLES_EQUAL(9e-6 + 9e-6, covariance(1, 1), 1e-15);
  DOUBLES_EQUAL(-30e-6, covariance(0, 1), 1e-15);
  DOUBLES_EQUAL(4e-6, covariance(2, 2), 1e-15);
}

TEST(Georeference, IsTheRigFrameWhenThereIsNone) {
  Georeference().Apply(OneTarget(FixStatus::kTracked), fixes);
  CHECK_FALSE(fixes.georeferenced);
  CHECK((fixes.targets[0].position_s_m - Vector3d(3, -1, 40)).norm() == 0);
  CHECK((fixes.targets[0].leds_s_m[1] - Vector3d(3, -1, 40.25)).norm() == 0);
  DOUBLES_EQUAL(4e-6, fixes.targets[0].covariance_s_m2(1, 1), 0);
}

TEST(Georeference, GivesALostTargetNoPlaceOnTheGrid) {
  Georeference(LookingNorth()).Apply(OneTarget(FixStatus::kLost), fixes);
  LONGS_EQUAL(1, fixes.targets.size());
  CHECK(fixes.targets[0].position_s_m.isZero());
  CHECK(fixes.targets[0].state.points.status == FixStatus::kLost);
}

TEST(Georeference, ForgetsThePairBefore) {
  const Georeference georeference(LookingNorth());
  georeference.Apply(OneTarget(FixStatus::kTracked), fixes);
  georeference.Apply(adit::track::TargetStateSet{}, fixes);
  LONGS_EQUAL(0, fixes.targets.size());
}

TEST(Georeference, ABodyHasAnAttitudeOnTheGridAndNoneInTheRigFrame) {
  auto states = OneTarget(FixStatus::kTracked);
  // It drives away from the rig, level: forward is the rig's z, left its -x, up its -y.
  adit::track::BodyPose pose;
  pose.T_b_t.rotation << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  states.targets[0].pose = pose;
  Georeference(LookingNorth()).Apply(states, fixes);
  CHECK(fixes.targets[0].attitude.has_value());
  DOUBLES_EQUAL(0, fixes.targets[0].attitude->heading_rad, 1e-12);
  DOUBLES_EQUAL(0, fixes.targets[0].attitude->pitch_rad, 1e-12);
  DOUBLES_EQUAL(0, fixes.targets[0].attitude->roll_rad, 1e-12);
  Georeference().Apply(states, fixes);
  CHECK_FALSE(fixes.targets[0].attitude.has_value());
  Georeference(LookingNorth()).Apply(OneTarget(FixStatus::kTracked), fixes);
  CHECK_FALSE(fixes.targets[0].attitude.has_value());
}
