// A body through time: what is said of it, and where its bars are expected.
#include <algorithm>
#include <cmath>

#include "firmware/track/tracker.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/nees.h"
#include "tests/unit/firmware/track/bar_stand.h"
#include "tests/unit/firmware/track/simulated_body.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::tests::BarNoise;
using adit::tests::kBars;
using adit::tests::kPeriodNs;
using adit::tests::SimulatedBody;
using Eigen::Vector3d;

namespace {

/// A loader that drives away from the cameras, turning a little, in front of a tracker.
struct Site {
  explicit Site(std::size_t bars, bool filter = false, unsigned seed = 1)
      : truth(adit::tests::Loader(bars), seed), tracker(kBars, {{}, filter, {truth.body}}) {}

  /// One more pair, in which the bars of `seen` are seen.
  void Show(const std::vector<std::size_t>& seen, const Vector3d& off_m = Vector3d::Zero()) {
    now_ns += kPeriodNs;
    truth.T_b_t.translation_m += Vector3d(0, 0, 0.016 * 4);
    truth.Turn({0, 0.016 * 0.2, 0});
    adit::stereo::PointSet points;
    points.stamp.mid_exposure_ns = now_ns;
    for (std::size_t i = 0; i < kBars.size(); ++i) {
      adit::stereo::TargetPoints target;
      target.target = static_cast<std::uint8_t>(i);
      if (std::find(seen.begin(), seen.end(), i) != seen.end()) {
        const auto place = truth.Measure(i, noise, kBars[i].epicenter_m);
        target.status = FixStatus::kTracked;
        target.epicenter_b_m = place.point_b_m + off_m;
        target.direction_b = place.direction_b;
        target.epicenter_covariance_m2 = place.covariance.topLeftCorner<3, 3>();
        target.direction_covariance = place.covariance.bottomRightCorner<3, 3>();
        target.epicenter_direction_covariance_m = place.covariance.topRightCorner<3, 3>();
        target.reprojection_px = 0.1;
      }
      points.targets.push_back(target);
    }
    tracker.Track(points, states);
  }
  const adit::track::TargetState& Told() const { return states.targets[kBars.size()]; }
  double ErrorM() const { return (Told().points.epicenter_b_m - truth.T_b_t.translation_m).norm(); }
  double SigmaM() const { return std::sqrt(Told().points.epicenter_covariance_m2.trace()); }

  SimulatedBody truth;
  BarNoise noise;
  adit::base::TimeNs now_ns = 1'000'000'000;
  adit::track::Tracker tracker;
  adit::track::TargetStateSet states;
  adit::stereo::ExpectationSet expected;
};

}  // namespace

TEST_GROUP(BodyTrack){};

TEST(BodyTrack, FollowsItsBarsInTheStatesWithItsPose) {
  Site site(2);
  for (int i = 0; i < 5; ++i) {
    site.Show({0, 1});
    LONGS_EQUAL(kBars.size() + 1, site.states.targets.size());
    const auto& told = site.Told();
    CHECK(told.points.status == FixStatus::kTracked);
    LONGS_EQUAL(kBars.size(), told.points.target);
    CHECK(told.mid_exposure_ns == site.now_ns && told.last_seen_ns == site.now_ns);
    CHECK(told.pose.has_value());
    CHECK(site.ErrorM() < 4 * site.SigmaM());
    CHECK(told.points.direction_b == told.pose->T_b_t.rotation.col(0));
    CHECK(told.points.leds_b_m[0] == told.points.epicenter_b_m);
    CHECK(told.points.leds_b_m[3].isApprox(told.pose->T_b_t * Vector3d(0, 0, 1)));
    DOUBLES_EQUAL(0.1, told.points.reprojection_px, 1e-12);
  }
}

TEST(BodyTrack, OneBarIsNoPoseAndNoneIsTheBarsOwnReason) {
  Site site(2);
  site.Show({0, 1});
  site.Show({1});
  CHECK(site.Told().points.status == FixStatus::kLost);
  CHECK(site.Told().points.reason == LossReason::kOneBar);
  CHECK_FALSE(site.Told().pose.has_value());
  CHECK(site.Told().points.epicenter_b_m.isZero());
  CHECK(site.Told().last_seen_ns == site.now_ns - kPeriodNs);
  site.Show({});
  CHECK(site.Told().points.reason == LossReason::kNotSeen);
}

TEST(BodyTrack, IsLostWhenItsBarsDoNotFitOneAnother) {
  Site site(2);
  site.truth.built.bars[1].led1_t_m += Vector3d(0.2, 0, 0);  // somebody moved a bar
  site.Show({0, 1});
  CHECK(site.Told().points.reason == LossReason::kGeometry);
  CHECK(site.states.targets[0].points.status == FixStatus::kTracked);  // the bars are where they are
}

TEST(BodyTrack, TakesInNoBarThatTheTrackingDoesNotBelieve) {
  Site site(3);
  for (int i = 0; i < 10; ++i) site.Show({0, 1, 2});
  site.Show({0, 1, 2}, {2, 0, 0});
  CHECK(site.states.targets[0].points.reason == LossReason::kJump);
  CHECK(site.Told().points.status == FixStatus::kLost);
}

TEST(BodyTrack, ALostBarIsExpectedWhereTheOthersHoldItSeeds1To100) {
  double sum = 0;
  constexpr unsigned kRuns = 100;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    Site site(3, false, seed);
    for (int i = 0; i < 10; ++i) site.Show({0, 1, 2});
    for (int i = 0; i < 125; ++i) site.Show({0, 1});  // 2 s: its own lock is long over
    site.tracker.Expect(site.now_ns + 1, site.expected);
    const auto& expected = site.expected[2];
    CHECK(expected.known);
    const Vector3d error_m = site.truth.Point(site.truth.built.bars[2], 0) - expected.led1_b_m;
    const Eigen::Matrix3d of_led1_m2 = expected.covariance.topLeftCorner<3, 3>();
    CHECK(std::sqrt(of_led1_m2.trace()) < 0.03);
    sum += adit::support::Nees(error_m, of_led1_m2);
  }
  // Not too sure; how much too careful depends on how evenly it drives.
  CHECK(sum / kRuns < 3 + 1.96 * std::sqrt(2 * 3.0 / kRuns));
}

TEST(BodyTrack, OneBarHoldsTheOtherForAWhileAndThenNoLonger) {
  Site site(2);
  for (int i = 0; i < 20; ++i) site.Show({0, 1});
  int held = 0;
  for (; held < 400; ++held) {
    site.Show({0});
    site.tracker.Expect(site.now_ns + kPeriodNs, site.expected);
    CHECK(site.expected[0].known);
    if (!site.expected[1].known) break;
  }
  CHECK(held * kPeriodNs > 500 * kNsPerMs);    // longer than alone
  CHECK(held * kPeriodNs <= 1000 * kNsPerMs);  // a turn around the one that is seen would go unnoticed
}

TEST(BodyTrack, ExpectsNothingOfABodyThatWasNotSeen) {
  Site site(2);
  site.Show({0});
  site.tracker.Expect(site.now_ns + kPeriodNs, site.expected);
  CHECK_FALSE(site.expected[1].known);
}

TEST(BodyTrack, WithTheFilterABodyWithOneBarIsPredictedForAWhile) {
  Site site(2, true);
  for (int i = 0; i < 30; ++i) site.Show({0, 1});
  CHECK(site.Told().points.status == FixStatus::kTracked);
  double before_m = 0;
  int predicted = 0;
  for (int i = 0; i < 300; ++i) {
    site.Show({0});
    if (site.Told().points.status != FixStatus::kPredicted) break;
    CHECK(site.SigmaM() > before_m);
    CHECK(site.ErrorM() < 4 * site.SigmaM());
    before_m = site.SigmaM();
    ++predicted;
  }
  CHECK(predicted > 2);
  CHECK(site.Told().points.reason == LossReason::kOneBar);
}

TEST(BodyTrack, TakesNoMemory) {
  Site site(3, true);
  for (int i = 0; i < 3; ++i) site.Show({0, 1, 2});
  adit::stereo::PointSet points;
  points.stamp.mid_exposure_ns = site.now_ns + kPeriodNs;
  for (std::size_t i = 0; i < kBars.size(); ++i) points.targets.push_back({});
  const auto before = adit::support::AllocationCount();
  site.tracker.Expect(site.now_ns + kPeriodNs, site.expected);
  site.tracker.Track(points, site.states);
  CHECK(site.expected[2].known);
  CHECK(adit::support::AllocationCount() == before);
}
