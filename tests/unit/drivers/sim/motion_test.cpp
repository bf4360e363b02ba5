#include "drivers/sim/motion.h"

#include <cmath>
#include <numbers>

#include "drivers/sim/projection.h"
#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::sim::Course;
using adit::sim::Curve;
using adit::sim::Drive;
using adit::sim::Ground;
using adit::sim::MakeDrive;
using adit::sim::MakePath;
using adit::sim::MiddleFrame;
using adit::sim::MotionPtr;
using adit::sim::Wave;
using adit::sim::WaveBar;
using adit::sim::Waypoint;
using Eigen::Vector3d;

namespace {

void CheckNear(const Vector3d& expected, const Vector3d& actual, double tolerance) {
  for (int i = 0; i < 3; ++i) DOUBLES_EQUAL(expected[i], actual[i], tolerance);
}

Course Corner(Curve curve, bool repeat) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  return {{{1, {0, 0, 10}, x}, {3, {2, 0, 10}, y}, {4, {2, 0, 14}, -x}, {6, {0, 0, 10}, x}}, curve, repeat};
}

}  // namespace

TEST_GROUP(Motion){};

TEST(Motion, PassesItsWaypointsOnEitherCurve) {
  for (const Curve curve : {Curve::kLinear, Curve::kSpline}) {
    const Course course = Corner(curve, false);
    const MotionPtr motion = MakePath(course, {});
    for (const Waypoint& waypoint : course.waypoints) {
      CheckNear(waypoint.at_m, motion->At(waypoint.t_s).translation_m, 1e-12);
      CheckNear(waypoint.direction, motion->At(waypoint.t_s).rotation.col(0), 1e-9);
    }
  }
}

TEST(Motion, GoesStraightAndTurnsEvenlyBetweenWaypoints) {
  const MotionPtr motion = MakePath(Corner(Curve::kLinear, false), {});
  CheckNear({0.5, 0, 10}, motion->At(1.5).translation_m, 1e-12);
  const double turned_rad = std::numbers::pi / 8;
  CheckNear({std::cos(turned_rad), std::sin(turned_rad), 0}, motion->At(1.5).rotation.col(0), 1e-12);
}

TEST(Motion, StandsBeforeAndAfterItsPath) {
  const MotionPtr motion = MakePath(Corner(Curve::kSpline, false), {});
  CheckNear({0, 0, 10}, motion->At(-5).translation_m, 0);
  CheckNear({0, 0, 10}, motion->At(100).translation_m, 0);
  CHECK_FALSE(motion->AtRest());
  CHECK_TRUE(MakePath({{Waypoint{}}, Curve::kLinear, false}, {})->AtRest());
}

TEST(Motion, RepeatsWithoutAJumpOrAKink) {
  const MotionPtr motion = MakePath(Corner(Curve::kSpline, true), {});
  for (const double t_s : {1.2, 2.9, 5.5})
    CheckNear(motion->At(t_s).translation_m, motion->At(t_s + 10).translation_m, 1e-9);
  constexpr double kStepS = 1e-4;
  const Vector3d before = motion->At(6).translation_m - motion->At(6 - kStepS).translation_m;
  const Vector3d after = motion->At(6 + kStepS).translation_m - motion->At(6).translation_m;
  CheckNear(before / kStepS, after / kStepS, 1e-2);
}

TEST(Motion, OfASplineHasNoKinkAtAWaypoint) {
  const MotionPtr motion = MakePath(Corner(Curve::kSpline, false), {});
  constexpr double kStepS = 1e-4;
  const Vector3d before = motion->At(3).translation_m - motion->At(3 - kStepS).translation_m;
  const Vector3d after = motion->At(3 + kStepS).translation_m - motion->At(3).translation_m;
  CheckNear(before / kStepS, after / kStepS, 1e-2);
}

TEST(Motion, TurnsThroughOppositeDirections) {
  const Course course{{{0, {0, 0, 1}, {1, 0, 0}}, {2, {0, 0, 1}, {-1, 0, 0}}}, Curve::kLinear, false};
  const Vector3d halfway = MakePath(course, {})->At(1).rotation.col(0);
  DOUBLES_EQUAL(1, halfway.norm(), 1e-12);
  DOUBLES_EQUAL(0, halfway.x(), 1e-6);
}

TEST(Motion, OfADriveStartsAndTurnsWhereItShould) {
  Drive drive;
  drive.from_m = {1, 0, 20}, drive.to_m = {1, 0, 100}, drive.duration_s = 20;
  const MotionPtr motion = MakeDrive(drive, {});
  CheckNear({1, 0, 20}, motion->At(0).translation_m, 1e-12);
  CheckNear({1, 0, 60}, motion->At(10).translation_m, 1e-12);
  CheckNear({1, 0, 100}, motion->At(20).translation_m, 1e-12);
  CheckNear({1, 0, 20}, motion->At(40).translation_m, 1e-12);
  CheckNear({1, 0, 0}, motion->At(10).rotation.col(0), 1e-12);
}

TEST(Motion, OfADriveWeavesWithItsHeadingAndShakes) {
  Drive drive;
  drive.from_m = {0, 0, 20}, drive.to_m = {0, 0, 100}, drive.duration_s = 20;
  drive.weave_m = 0.5, drive.weave_period_s = 8;
  CheckNear({0.5, 0, 20 + 40 * (1 - std::cos(std::numbers::pi * 0.1))},
            MakeDrive(drive, {})->At(2).translation_m, 1e-12);
  // At t = 0 it moves to the right at 2 pi 0.5 / 8 m/s and, on average, ahead at 4 m/s.
  const double heading_rad = std::atan2(2 * std::numbers::pi * 0.5 / 8, 4);
  CheckNear({std::sin(heading_rad), 0, std::cos(heading_rad)}, MakeDrive(drive, {})->At(0).rotation.col(2),
            1e-12);
  drive.vibration_m = 0.01, drive.vibration_hz = 25;
  double highest_m = 0;
  for (int i = 0; i < 1000; ++i)
    highest_m = std::max(highest_m, std::abs(MakeDrive(drive, {})->At(0.001 * i).translation_m.y()));
  DOUBLES_EQUAL(0.01, highest_m, 1e-4);
}

TEST(Motion, IsGivenInTheGroundFrame) {
  adit::base::Pose<adit::base::Rig, Ground> T_b_g;
  T_b_g.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
  T_b_g.translation_m = {5, 0, 0};
  // z ahead in the ground is x to the right in the rig.
  const Course course{{{0, {0, 1, 10}, Vector3d::UnitZ()}}, Curve::kLinear, false};
  CheckNear({15, 1, 0}, MakePath(course, T_b_g)->At(0).translation_m, 1e-12);
  CheckNear({1, 0, 0}, MakePath(course, T_b_g)->At(0).rotation.col(0), 1e-12);
  Drive drive;
  drive.from_m = {0, 0, 10}, drive.to_m = {0, 0, 20};
  CheckNear({25, 0, 0}, MakeDrive(drive, T_b_g)->At(1).translation_m, 1e-12);
}

TEST(Motion, OfAWaveKeepsTheBarInBothImagesAndTurnsItEveryWay) {
  const auto rig = adit::tests::SceneOf(adit::tests::kSmallRig).rig;
  adit::base::Target bar;
  bar.leds_m = {0, 0.2, 0.5, 1};
  Wave wave;
  wave.nearest_m = 8, wave.farthest_m = 25, wave.step_s = 0.5, wave.length_s = 100;
  const auto poses = WaveBar(wave, bar, rig);
  LONGS_EQUAL(201, poses.size());
  CheckNear(poses.front().at_m, poses.back().at_m, 0);
  int right = 0, down = 0, away = 0;
  for (const Waypoint& pose : poses) {
    for (const double place_m : bar.leds_m) {
      const Vector3d led_m = pose.at_m + place_m * pose.direction;
      const auto left_px = adit::sim::ProjectPoint(rig.left, led_m);
      const auto right_px = adit::sim::ProjectPoint(rig.right, rig.T_r_l * led_m);
      CHECK_TRUE(left_px->minCoeff() > 0 && left_px->x() < 319 && left_px->y() < 239);
      CHECK_TRUE(right_px->minCoeff() > 0 && right_px->x() < 319 && right_px->y() < 239);
    }
    CHECK_TRUE(std::abs(pose.direction.z()) <= wave.lean_max);
    DOUBLES_EQUAL(1, pose.direction.norm(), 1e-12);
    right += pose.direction.x() > 0, down += pose.direction.y() > 0, away += pose.direction.z() > 0;
  }
  for (const int count : {right, down, away}) CHECK_TRUE(count > 70 && count < 131);  // 4 sigma of 200 coins
}

TEST(Motion, OfAWaveFindsNothingWhereTheImagesShareNoRoom) {
  const auto rig = adit::tests::SceneOf(adit::tests::kSmallRig).rig;
  adit::base::Target bar;
  bar.leds_m = {0, 0.2, 0.5, 1};
  Wave wave;
  wave.nearest_m = 0.5, wave.farthest_m = 1;
  CHECK_TRUE(WaveBar(wave, bar, rig).empty());
}

TEST(Motion, InTheMiddleFrameTheCamerasStandLeftAndRightAndLookAhead) {
  const auto rig = adit::tests::SceneOf(adit::tests::kSmallRig).rig;
  const auto T_g_b = MiddleFrame(rig).Inverse();
  CheckNear({-0.5, 0, 0}, T_g_b * Vector3d::Zero(), 1e-12);
  CheckNear({0.5, 0, 0}, T_g_b * rig.T_r_l.Inverse().translation_m, 1e-12);
  // Both optical axes meet at converge_m.
  const double toe_rad = std::atan2(0.5, 20.0);
  CheckNear({0, 0, 20}, T_g_b * Vector3d(0, 0, 20 / std::cos(toe_rad)), 1e-12);
  CheckNear({0, 0, 20}, T_g_b * (rig.T_r_l.Inverse() * Vector3d(0, 0, 20 / std::cos(toe_rad))), 1e-12);
}
