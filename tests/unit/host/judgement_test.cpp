#include "host/judgement.h"

#include <array>
#include <cmath>

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Judge;
using adit::host::Outcome;
using adit::sim::TargetTruth;
using adit::stereo::FixStatus;
using adit::stereo::TargetPoints;
using Eigen::Vector3d;

TargetTruth Bar(std::size_t target, const Vector3d& led1_m) {
  TargetTruth truth;
  truth.target = target;
  truth.direction = Vector3d::UnitX();
  for (std::size_t i = 0; i < 4; ++i)
    truth.leds_m[i] = led1_m + std::array{0.0, 0.25, 0.65, 1.5}[i] * truth.direction;
  truth.epicenter_m = truth.leds_m[3];
  return truth;
}

/// As it is, but for an error; one standard deviation is 1 mm in x and y, 3 mm in z.
TargetPoints Reported(const TargetTruth& truth, const Vector3d& error_m) {
  TargetPoints points;
  points.status = FixStatus::kTracked;
  points.epicenter_b_m = truth.epicenter_m + error_m;
  points.epicenter_covariance_m2 = Vector3d(1e-6, 1e-6, 9e-6).asDiagonal();
  for (std::size_t i = 0; i < 4; ++i) points.leds_b_m[i] = truth.leds_m[i] + error_m;
  return points;
}

const std::array<TargetTruth, 2> kTruths{Bar(0, {0, 0, 30}), Bar(1, {4, 1, 40})};

}  // namespace

TEST_GROUP(Judgement){};

TEST(Judgement, AllowsFiveSigmasAndTenMillimetresAlongTheError) {
  CHECK(Outcome::kFound == Judge(Reported(kTruths[0], {0.0149, 0, 0}), kTruths[0], kTruths).outcome);
  CHECK(Outcome::kOff == Judge(Reported(kTruths[0], {0.0151, 0, 0}), kTruths[0], kTruths).outcome);
  CHECK(Outcome::kFound == Judge(Reported(kTruths[0], {0, 0, 0.0249}), kTruths[0], kTruths).outcome);
  CHECK(Outcome::kOff == Judge(Reported(kTruths[0], {0, 0, 0.0251}), kTruths[0], kTruths).outcome);
}

TEST(Judgement, MeasuresTheErrorInStatedSigmas) {
  const auto judgement = Judge(Reported(kTruths[0], {0.001, -0.002, 0.003}), kTruths[0], kTruths);
  DOUBLES_EQUAL(1 + 4 + 1, judgement.nees, 1e-9);
  DOUBLES_EQUAL(std::sqrt(14e-6), judgement.error_m, 1e-12);
}

TEST(Judgement, AnotherTargetsPlaceIsASwap) {
  CHECK(Outcome::kSwapped == Judge(Reported(kTruths[1], {0, 0, 0}), kTruths[0], kTruths).outcome);
}

TEST(Judgement, ABarReadBackwardsIsASwap) {
  TargetPoints points = Reported(kTruths[0], {0, 0, 0});
  for (std::size_t i = 0; i < 4; ++i) points.leds_b_m[i] = kTruths[0].leds_m[3 - i];
  CHECK(Outcome::kSwapped == Judge(points, kTruths[0], kTruths).outcome);
}

TEST(Judgement, NoPositionIsLostAndOneThatIsNoNumberIsOff) {
  CHECK(Outcome::kLost == Judge(TargetPoints{}, kTruths[0], kTruths).outcome);
  TargetPoints points = Reported(kTruths[0], {0, 0, 0});
  points.epicenter_b_m.x() = NAN;
  CHECK(Outcome::kOff == Judge(points, kTruths[0], kTruths).outcome);
}
