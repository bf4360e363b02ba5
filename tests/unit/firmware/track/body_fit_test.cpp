#include "firmware/track/body_fit.h"

#include <cmath>

#include "tests/support/nees.h"
#include "tests/unit/firmware/track/simulated_body.h"

#include <CppUTest/TestHarness.h>

using adit::tests::BarNoise;
using adit::tests::Loader;
using adit::tests::SimulatedBody;
using adit::track::BodyPose;
using adit::track::FitBody;
using adit::track::SeenBars;
using Eigen::Vector3d;

namespace {

SeenBars MeasureAll(SimulatedBody& truth, const BarNoise& noise) {
  SeenBars seen;
  for (std::size_t i = 0; i < truth.body.bars.size(); ++i)
    seen[i] = truth.Measure(i, noise, truth.body.bars[i].centre_m);
  return seen;
}

/// (origin, rotation vector in the rig's axes): true minus fitted.
Eigen::Matrix<double, 6, 1> ErrorOf(const SimulatedBody& truth, const BodyPose& pose) {
  const Eigen::AngleAxisd turn(truth.T_b_t.rotation * pose.T_b_t.rotation.transpose());
  Eigen::Matrix<double, 6, 1> error;
  error << truth.T_b_t.translation_m - pose.T_b_t.translation_m, turn.angle() * turn.axis();
  return error;
}

}  // namespace

TEST_GROUP(BodyFit){};

TEST(BodyFit, FindsTheBodyExactlyWithoutNoise) {
  auto body = Loader(2);
  body.sigma_m = 1e-9;
  SimulatedBody truth(body, 3);
  const auto pose = FitBody(body, MeasureAll(truth, {Vector3d::Constant(1e-9), 1e-9}));
  CHECK(pose.has_value());
  CHECK(ErrorOf(truth, *pose).norm() < 1e-7);
}

TEST(BodyFit, ErrorsOfAllSixAreAsLargeAsTheirCovarianceSaysSeeds1To400) {
  for (const std::size_t bars : {2U, 3U}) {
    // Near and far; and with one bar of which three LEDs were left.
    for (const BarNoise& noise : {BarNoise{}, BarNoise{{4e-4, 4e-4, 4e-3}, 4e-3}}) {
      double sum = 0;
      constexpr unsigned kRuns = 400;
      for (unsigned seed = 1; seed <= kRuns; ++seed) {
        SimulatedBody truth(Loader(bars), seed);
        SeenBars seen = MeasureAll(truth, noise);
        seen[1] = truth.Measure(1, {3 * noise.centre_sigma_m, 3 * noise.direction_sigma_rad},
                                truth.body.bars[1].centre_m);
        const auto pose = FitBody(truth.body, seen);
        CHECK(pose.has_value());
        const auto error = ErrorOf(truth, *pose);
        sum += adit::support::Nees(error, pose->covariance);
      }
      // The 95 % bounds of a mean of that many chi-squares of 6.
      DOUBLES_EQUAL(6, sum / kRuns, 1.96 * std::sqrt(2 * 6.0 / kRuns));
    }
  }
}

TEST(BodyFit, ThreeBarsSayMoreThanTwo) {
  SimulatedBody two(Loader(2), 1), three(Loader(3), 1);
  const auto pose_of_two = FitBody(two.body, MeasureAll(two, {}));
  const auto pose_of_three = FitBody(three.body, MeasureAll(three, {}));
  const double of_two_m2 = pose_of_two->covariance.diagonal().head<3>().sum();
  CHECK(pose_of_three->covariance.diagonal().head<3>().sum() < of_two_m2);
}

TEST(BodyFit, DeclinesOneBarAlone) {
  SimulatedBody truth(Loader(2), 1);
  SeenBars seen = MeasureAll(truth, {});
  seen[0].reset();
  CHECK_FALSE(FitBody(truth.body, seen).has_value());
  seen[1].reset();
  CHECK_FALSE(FitBody(truth.body, seen).has_value());
}

TEST(BodyFit, DeclinesBarsThatDoNotFitTheBody) {
  SimulatedBody truth(Loader(2), 1);
  SeenBars apart = MeasureAll(truth, {});
  apart[1]->point_b_m += Vector3d(0.3, 0, 0);
  CHECK_FALSE(FitBody(truth.body, apart).has_value());
  SeenBars twisted = MeasureAll(truth, {});
  twisted[1]->direction_b = (twisted[1]->direction_b + Vector3d(0, 0.3, 0)).normalized();
  CHECK_FALSE(FitBody(truth.body, twisted).has_value());
  SeenBars mixed_up = MeasureAll(truth, {});
  std::swap(mixed_up[0], mixed_up[1]);
  CHECK_FALSE(FitBody(truth.body, mixed_up).has_value());
}

TEST(BodyFit, PutsUpWithACalibrationThatIsALittleOff) {
  SimulatedBody truth(Loader(3), 1);
  SeenBars seen = MeasureAll(truth, {});
  for (auto& bar : seen)
    if (bar) bar->point_b_m *= 1.003;
  CHECK(FitBody(truth.body, seen).has_value());
}

TEST(BodyFit, DeclinesBarsThatHardlyShowATurn) {
  auto body = Loader(2);
  // Nearly on one line, and seen from far away.
  body.bars[1].led1_t_m = body.bars[0].led1_t_m + 2 * body.bars[0].direction_t + Vector3d(0, 0, 0.06);
  body.bars[1].direction_t = body.bars[0].direction_t;
  SimulatedBody truth(body, 1);
  CHECK_FALSE(FitBody(body, MeasureAll(truth, {{4e-4, 4e-4, 5e-3}, 5e-3})).has_value());
}
