#include "host/training.h"

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "tests/support/synthetic_rig.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::GeometryModel;
using adit::host::NoiseRanges;
using adit::host::RefinedModel;
using adit::host::TrainingOptions;
using adit::host::TrainingTally;
using adit::identify::Model;

/// Targets 1 and 2 of the seed (chapter 5), J = 2.2707 and 2.1109.
adit::base::Target SeedTarget(int number) {
  adit::base::Target target;
  target.name = "seed";
  if (number == 1)
    target.leds_m = {0, 0.25, 0.65, 1.5};
  else
    target.leds_m = {0, 0.25, 0.80, 1.5};
  return target;
}

/// The p2 invariant by the polynomials of the seed's README, of four image points.
double P2Of(const std::array<Eigen::Vector2d, 4>& p) {
  const double l =
      ((p[0] - p[1]).norm() / (p[1] - p[3]).norm()) / ((p[0] - p[2]).norm() / (p[2] - p[3]).norm());
  const double upper = 2 * std::pow(l, 6) - 6 * std::pow(l, 5) + 9 * std::pow(l, 4) - 8 * std::pow(l, 3) +
                       9 * l * l - 6 * l + 2;
  const double lower =
      std::pow(l, 6) - 3 * std::pow(l, 5) + 3 * std::pow(l, 4) - std::pow(l, 3) + 3 * l * l - 3 * l + 1;
  return upper / lower;
}

}  // namespace

TEST_GROUP(Training){};

TEST(Training, HoldsTheInvariantsThatTheSeedPrints) {
  const Model first = GeometryModel(SeedTarget(1), {}), second = GeometryModel(SeedTarget(2), {});
  CHECK(first.p2_min < 2.2707 && 2.2707 < first.p2_max);
  CHECK(second.p2_min < 2.1109 && 2.1109 < second.p2_max);
}

// 200 000 noisy views over all distances and tilts, projected by the test's own code: at 4.5 sigma hardly one
// may fall outside, and the ranges must not be so wide that they say nothing.
TEST(Training, NoiseRangesHoldWhatNoiseMakesOfTheTarget) {
  const adit::tests::SyntheticRig camera;
  std::mt19937_64 random(1);
  const TrainingOptions options;
  const Model model = NoiseRanges(SeedTarget(1), options);
  int outside_p2 = 0, outside_length = 0;
  double p2_min = 9, p2_max = 0;
  for (int n = 0; n < 200'000; ++n) {
    const double z = options.nearest_m * std::pow(22, adit::tests::Uniform(random, 0, 1));
    const double tilt = options.tilt_max_rad * adit::tests::Uniform(random, -1, 1);
    const double turn = adit::tests::Uniform(random, 0, 6.283);
    const Eigen::Vector3d direction(std::cos(tilt) * std::cos(turn), std::cos(tilt) * std::sin(turn),
                                    std::sin(tilt));
    std::array<Eigen::Vector2d, 4> leds;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d p = Eigen::Vector3d(0, 0, z) + (model.target.leds_m[i] - 0.75) * direction;
      leds[i] =
          camera.Left(p) + 0.05 * Eigen::Vector2d(adit::tests::Gauss(random), adit::tests::Gauss(random));
    }
    const double p2 = P2Of(leds), length_px = (leds[3] - leds[0]).norm();
    p2_min = std::min(p2_min, p2), p2_max = std::max(p2_max, p2);
    outside_p2 += p2 < model.p2_min || p2 > model.p2_max ? 1 : 0;
    outside_length += length_px < model.length_min_px || length_px > model.length_max_px ? 1 : 0;
  }
  CHECK_COMPARE(outside_p2, <=, 3);
  LONGS_EQUAL(0, outside_length);
  CHECK_COMPARE(model.p2_max - model.p2_min, <, 1.6 * (p2_max - p2_min));
}

TEST(Training, GrowsWithNoiseAndDistance) {
  TrainingOptions far, noisy, near;
  far.farthest_m = 150, noisy.noise_px = 0.1, near.farthest_m = 50;
  const auto width = [](const TrainingOptions& options) {
    const Model model = NoiseRanges(SeedTarget(1), options);
    return model.p2_max - model.p2_min;
  };
  CHECK_COMPARE(width(near), <, width({}));
  CHECK_COMPARE(width({}), <, width(far));
  CHECK_COMPARE(width({}), <, width(noisy));
}

TEST(Training, IsNeverNarrowerThanNoiseNeeds) {
  const Model noise = NoiseRanges(SeedTarget(1), {});
  TrainingTally tally;
  for (int i = 0; i < 100; ++i) tally.samples.push_back({2.2707, 0.0001, 300});

  const Model refined = RefinedModel(noise, tally);

  DOUBLES_EQUAL(noise.p2_min, refined.p2_min, 0);
  DOUBLES_EQUAL(noise.p2_max, refined.p2_max, 0);
  DOUBLES_EQUAL(noise.collinearity_max, refined.collinearity_max, 0);
  DOUBLES_EQUAL(noise.length_min_px, refined.length_min_px, 0);
}

TEST(Training, WidensToWhatWasMeasuredButNotToALampNowAndThen) {
  const Model noise = NoiseRanges(SeedTarget(1), {});
  TrainingTally tally;
  for (int i = 0; i < 1000; ++i)
    tally.samples.push_back({noise.p2_max + 0.01 * (i % 2), 2 * noise.collinearity_max, 15});
  tally.samples.push_back({2.79, 0.9, 15});

  const Model refined = RefinedModel(noise, tally);

  DOUBLES_EQUAL(noise.p2_max + 0.012, refined.p2_max, 1e-9);
  DOUBLES_EQUAL(2.5 * noise.collinearity_max, refined.collinearity_max, 1e-9);
  DOUBLES_EQUAL(13.5, refined.length_min_px, 1e-9);
}
