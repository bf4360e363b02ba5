#include "host/data_snooping.h"

#include <cmath>
#include <cstdio>

#include "tests/support/nees.h"
#include "tests/unit/host/survey_truth.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CommonPoint;
using adit::host::FitHelmert;
using adit::host::Helmert;
using adit::host::HelmertOptions;
using adit::host::Snoop;
using adit::host::Snooping;
using adit::test::SurveyTruth;
using Eigen::Vector3d;

constexpr unsigned kFirstSeed = 1000, kRuns = 1000;

Snooping SnoopedFit(const std::vector<CommonPoint>& points, const HelmertOptions& options = {}) {
  const auto fit = FitHelmert(points, options);
  CHECK_TRUE(!!fit);
  return Snoop(points, *fit, options);
}

/// How often a wrong point is suspected, and it is that one. `told_sigma_m` is what the adjustment believes.
unsigned NamedIn1000Runs(double true_sigma_m, double told_sigma_m) {
  unsigned named = 0, suspected = 0;
  for (unsigned run = 0; run < kRuns; ++run) {
    SurveyTruth truth(kFirstSeed + run, true_sigma_m);
    auto points = truth.Measure();
    const auto wrong = static_cast<std::size_t>(truth.Uniform(0, 5));
    points[wrong].control_s_m += 0.020 * truth.Noise().normalized();
    for (CommonPoint& point : points)
      point.control_covariance_m2 = told_sigma_m * told_sigma_m * Eigen::Matrix3d::Identity();
    const Snooping snooping = SnoopedFit(points);
    suspected += snooping.suspects_blunder ? 1 : 0;
    named += snooping.suspects_blunder && snooping.worst == wrong ? 1 : 0;
  }
  std::printf("seeds %u to %u, noise %.1f mm, told %.1f mm: suspected in %u, named in %u of %u runs\n",
              kFirstSeed, kFirstSeed + kRuns - 1, true_sigma_m * 1e3, told_sigma_m * 1e3, suspected, named,
              kRuns);
  return named;
}

}  // namespace

TEST_GROUP(DataSnooping){};

TEST(DataSnooping, NamesABlunderOf20MillimetresInOneOfFivePoints) {
  CHECK_TRUE(NamedIn1000Runs(0.001, 0.001) >= 990);
  CHECK_TRUE(NamedIn1000Runs(0.0015, 0.0015) >= 990);
  // At 2 mm of noise in each coordinate some blunders drown in weakly checked coordinates.
  CHECK_TRUE(NamedIn1000Runs(0.002, 0.002) >= 970);
}

TEST(DataSnooping, NamesABlunderWhenSigmasAreTwiceTheTruth) {
  CHECK_TRUE(NamedIn1000Runs(0.001, 0.002) >= 990);
}

TEST(DataSnooping, SuspectsNobodyWhenNothingIsWrong) {
  unsigned suspected = 0, w_above = 0;
  double sigma0_squares = 0;
  for (unsigned run = 0; run < kRuns; ++run) {
    SurveyTruth truth(kFirstSeed + run);
    const auto points = truth.Measure();
    const Helmert fit = *FitHelmert(points, {});
    const Snooping snooping = Snoop(points, fit, {});
    suspected += snooping.suspects_blunder ? 1 : 0;
    for (const auto& test : snooping.tests)
      w_above += static_cast<unsigned>((test.w.array().abs() > snooping.w_critical).count());
    sigma0_squares += fit.sigma0 * fit.sigma0 / kRuns;
  }
  std::printf("seeds %u to %u: suspected in %u, |w| critical %u times, sigma0^2 %.3f ", kFirstSeed,
              kFirstSeed + kRuns - 1, suspected, w_above, sigma0_squares);
  // 5000 tests of 0.1 %: five are expected, and 15 have a probability of one in 5000.
  CHECK_TRUE(suspected <= 15);
  // 15000, less independent of each other.
  CHECK_TRUE(w_above <= 40);
  // Nine degrees of freedom, 1000 runs: one sigma is sqrt(2 / 9000) = 1.5 %.
  DOUBLES_EQUAL(1, sigma0_squares, 0.06);
}

TEST(DataSnooping, TheFitKnowsHowFarOffItIs) {
  double nees = 0;
  for (unsigned run = 0; run < kRuns; ++run) {
    SurveyTruth truth(kFirstSeed + run);
    const Helmert fit = *FitHelmert(truth.Measure(), {});
    const Vector3d target_b_m(1, 0.5, 50);
    const Vector3d error_m = fit.Apply(target_b_m) - truth.Place(target_b_m);
    const Eigen::Matrix<double, 3, 7> jacobian = fit.Jacobian(target_b_m);
    const Eigen::Matrix3d covariance = jacobian * fit.covariance * jacobian.transpose();
    nees += adit::support::Nees(error_m, covariance) / kRuns;
  }
  std::printf("seeds %u to %u: nees %.3f ", kFirstSeed, kFirstSeed + kRuns - 1, nees);
  DOUBLES_EQUAL(3, nees, 0.3);  // one sigma is sqrt(6 / 1000) = 0.08
}

TEST(DataSnooping, KnowsItsCriticalValues) {
  // Tables: normal 0.9995, chi-square 3 at 0.999, chi-square 9 at 0.95.
  const Snooping snooping = SnoopedFit(SurveyTruth(1).Measure());
  DOUBLES_EQUAL(3.2905, snooping.w_critical, 1e-4);
  DOUBLES_EQUAL(16.266, snooping.left_out_critical, 1e-3);
  DOUBLES_EQUAL(std::sqrt(16.919 / 9), snooping.sigma0_critical, 1e-4);
}

TEST(DataSnooping, RedundancyNumbersAddUpToTheRedundancy) {
  for (const bool tilt : {true, false}) {
    HelmertOptions options;
    options.estimate_tilt = tilt;
    double sum = 0;
    for (const auto& test : SnoopedFit(SurveyTruth(2).Measure(), options).tests) sum += test.redundancy.sum();
    DOUBLES_EQUAL(15 - options.Parameters(), sum, 1e-6);
  }
}

TEST(DataSnooping, LeavesOutAsAFitOfTheOthersDoes) {
  const auto points = SurveyTruth(3).Measure();
  const Snooping snooping = SnoopedFit(points);
  std::vector<CommonPoint> others(points.begin() + 1, points.end());
  const Helmert fit = *FitHelmert(others, {});
  CHECK((*snooping.tests[0].left_out_m - fit.Residual(points[0])).norm() < 1e-12);
  CHECK(snooping.tests[0].left_out_m->norm() > snooping.tests[0].residual_m.norm());
}

TEST(DataSnooping, CannotNameAPointOfThree) {
  auto points = SurveyTruth(4).Measure();
  points.resize(3);
  points[0].control_s_m.x() += 0.5;
  const Snooping snooping = SnoopedFit(points);
  CHECK_FALSE(snooping.worst.has_value());
  CHECK_FALSE(snooping.suspects_blunder);
  CHECK_FALSE(snooping.tests[0].left_out_m.has_value());
}
