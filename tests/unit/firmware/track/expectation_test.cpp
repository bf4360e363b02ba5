// What the tracker expects of the next pair.
#include <cmath>

#include "tests/support/nees.h"
#include "tests/unit/firmware/track/bar_stand.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::tests::kCentreM;
using adit::tests::kPeriodNs;
using adit::tests::Stand;

TEST_GROUP(Expectation){};

TEST(Expectation, NeedsTwoMeasurementsThatFitOneAnother) {
  Stand stand;
  CHECK_FALSE(stand.IsExpectedAfter(kPeriodNs));
  stand.Show();
  CHECK_FALSE(stand.IsExpectedAfter(kPeriodNs));
  stand.Move(kPeriodNs);
  stand.Show();
  CHECK(stand.IsExpectedAfter(kPeriodNs));
}

TEST(Expectation, IsNotBuiltOnTwoPlacesThatNoMachineCouldBeAt) {
  Stand stand;
  stand.Show();
  stand.Move(kPeriodNs);
  stand.truth.StartAt({4, 1, 40}, 1, 0.3);  // 2 m in 16 ms
  stand.Show();
  CHECK_FALSE(stand.IsExpectedAfter(kPeriodNs));
}

TEST(Expectation, HoldsTheBarAsItsCovarianceSaysSeeds1To300) {
  double sum = 0;
  constexpr unsigned kRuns = 300;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    Stand stand(seed);
    for (int i = 0; i < 8; ++i) {
      stand.Show();
      stand.Move(kPeriodNs);
    }
    stand.tracker.Expect(stand.now_ns, stand.expected);
    CHECK(stand.expected[0].known);
    Eigen::Matrix<double, 6, 1> error;
    error << stand.truth.CentreM() - kCentreM * stand.truth.Direction() - stand.expected[0].led1_b_m,
        stand.truth.Direction() - stand.expected[0].direction_b;
    // Along the direction nothing moves: any variance there leaves the other five as they are.
    Eigen::Matrix<double, 6, 6> covariance = stand.expected[0].covariance;
    covariance.bottomRightCorner<3, 3>() +=
        stand.expected[0].direction_b * stand.expected[0].direction_b.transpose();
    sum += adit::support::Nees(error, covariance);
  }
  DOUBLES_EQUAL(5, sum / kRuns, 1.96 * std::sqrt(2 * 5.0 / kRuns));
}

TEST(Expectation, GrowsLessSureAndEnds) {
  Stand stand;
  for (int i = 0; i < 30; ++i) {
    stand.Show();
    stand.Move(kPeriodNs);
  }
  stand.Hide();
  CHECK(stand.IsExpectedAfter(kPeriodNs));
  const double soon_m2 = stand.expected[0].covariance(2, 2);
  CHECK(stand.IsExpectedAfter(100 * kNsPerMs));
  CHECK(stand.expected[0].covariance(2, 2) > 10 * soon_m2);
  CHECK_FALSE(stand.IsExpectedAfter(500 * kNsPerMs));
  stand.Move(100 * kNsPerMs);
  stand.Show();
  CHECK(stand.IsExpectedAfter(kPeriodNs));
}

TEST(Expectation, IsNoneForAPairThatIsNotLater) {
  Stand stand;
  stand.Show();
  stand.Move(kPeriodNs);
  stand.Show();
  CHECK_FALSE(stand.IsExpectedAfter(0));
  CHECK_FALSE(stand.IsExpectedAfter(-kPeriodNs));
}

TEST(Expectation, StartsAnewWhenTheClockStepsBack) {
  Stand stand;
  stand.Show();
  stand.Move(kPeriodNs);
  stand.Show();
  stand.now_ns -= 10 * kNsPerS;
  stand.Show();
  CHECK_FALSE(stand.IsExpectedAfter(kPeriodNs));
  stand.Move(kPeriodNs);
  stand.Show();
  CHECK(stand.IsExpectedAfter(kPeriodNs));
}
