// What the tracker expects of the next pair.
#include <cmath>

#include "firmware/track/tracker.h"
#include "tests/unit/firmware/track/simulated_bar.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::base::Target;
using adit::base::TimeNs;
using adit::stereo::ExpectationSet;
using adit::stereo::FixStatus;
using adit::stereo::PointSet;
using adit::tests::SimulatedBar;
using adit::track::BarPlace;
using adit::track::TargetStateSet;
using adit::track::Tracker;
using Eigen::Vector3d;

namespace {

constexpr TimeNs kPeriodNs = 16 * kNsPerMs;
constexpr double kCentreM = 0.6, kEpicenterM = -0.5;
const Target kBar{"bar", {0, 0.25, 0.65, 1.5}, kEpicenterM, 0.04};

/// A bar in front of a tracker.
struct Stand {
  explicit Stand(unsigned seed = 1) : truth(seed) { truth.StartAt({2, 1, 40}, 1, 0.3); }

  void Move(TimeNs duration_ns) {
    now_ns += duration_ns;
    truth.Move(1e-9 * static_cast<double>(duration_ns), 2, 2);
  }
  void Show() {
    PointSet points;
    points.stamp.mid_exposure_ns = now_ns;
    const BarPlace measured = truth.Measure(sigma_m, sigma_rad, kEpicenterM - kCentreM);
    adit::stereo::TargetPoints target;
    target.status = FixStatus::kTracked;
    target.epicenter_b_m = measured.point_b_m;
    target.direction_b = measured.direction_b;
    target.epicenter_covariance_m2 = measured.covariance.topLeftCorner<3, 3>();
    target.direction_covariance = measured.covariance.bottomRightCorner<3, 3>();
    target.epicenter_direction_covariance_m = measured.covariance.topRightCorner<3, 3>();
    points.targets.push_back(target);
    tracker.Track(points, states);
  }
  void Hide() {
    PointSet points;
    points.stamp.mid_exposure_ns = now_ns;
    points.targets.push_back({});
    tracker.Track(points, states);
  }
  bool IsExpectedAfter(TimeNs duration_ns) {
    tracker.Expect(now_ns + duration_ns, expected);
    return expected[0].known;
  }

  SimulatedBar truth;
  Vector3d sigma_m{3e-4, 3e-4, 1.5e-3};
  double sigma_rad = 1e-3;
  TimeNs now_ns = kNsPerS;
  Tracker tracker{{kBar}};
  TargetStateSet states;
  ExpectationSet expected;
};

}  // namespace

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
    sum += error.dot(covariance.ldlt().solve(error));
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
