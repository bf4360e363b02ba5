// What the tracker believes, and what it says of the time in between.
#include <cmath>

#include "tests/unit/firmware/track/bar_stand.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::tests::kPeriodNs;
using adit::tests::Stand;
using Eigen::Vector3d;

namespace {

/// A stand whose bar was seen in 20 pairs.
struct LockedStand : Stand {
  explicit LockedStand(bool with_filter, unsigned seed = 1) : Stand(seed, with_filter) {
    for (int i = 0; i < 20; ++i) MoveAndShow();
  }
  /// Takes the bar elsewhere from one pair to the next, at the speed it had.
  void Jump(const Vector3d& by_m) { truth.Shift(by_m); }
};

double ErrorM(const Stand& stand) { return (stand.Told().epicenter_b_m - stand.Epicenter()).norm(); }

}  // namespace

TEST_GROUP(RawTrack){};

TEST(RawTrack, IsTheMeasurementAsItIs) {
  LockedStand with(true), without(false);
  for (int i = 0; i < 5; ++i) {
    with.MoveAndShow(), without.MoveAndShow();
    CHECK(without.Told().status == FixStatus::kTracked);
    CHECK(without.Told().epicenter_b_m == without.measured.point_b_m);
    CHECK(with.Told().epicenter_b_m != with.measured.point_b_m);
  }
}

TEST(RawTrack, DoesNotBelieveAPlaceWhereNoMachineCouldBe) {
  LockedStand stand(false);
  stand.Jump({1, 0, 0});
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kLost);
  CHECK(stand.Told().reason == LossReason::kJump);
  CHECK(stand.Told().epicenter_b_m.isZero());
  CHECK(stand.states.targets[0].last_seen_ns == stand.now_ns - kPeriodNs);
  stand.Jump({-1, 0, 0});  // it was something else
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kTracked);
}

TEST(RawTrack, BelievesItInTheSecondPairAndIsLockedThere) {
  LockedStand stand(false);
  stand.Jump({1, 0, 0});
  stand.MoveAndShow();
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kTracked);
  CHECK(stand.IsExpectedAfter(kPeriodNs));
  stand.Jump({0, 1, 0});
  stand.MoveAndShow();
  CHECK(stand.Told().reason == LossReason::kJump);
}

TEST(RawTrack, DoesNotBelieveTwoPlacesThatDisagreeWithOneAnother) {
  LockedStand stand(false);
  for (int i = 0; i < 6; ++i) {
    stand.Jump({0, i % 2 == 0 ? 2.0 : -3.5, 1});
    stand.MoveAndShow();
    CHECK(stand.Told().reason == LossReason::kJump);
  }
}

TEST(RawTrack, DoesNotBelieveABarThatHasTurnedRound) {
  LockedStand stand(false);
  stand.truth.TurnRound();
  stand.MoveAndShow();
  CHECK(stand.Told().reason == LossReason::kJump);
}

TEST(RawTrack, TakesBackAtOnceWhatWasHiddenForLongWhereverItIs) {
  LockedStand stand(false);
  for (int i = 0; i < 40; ++i) {
    stand.Move(kPeriodNs);
    stand.Hide();
    CHECK(stand.Told().status == FixStatus::kLost);
  }
  stand.Jump({3, -1, 10});
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kTracked);
}

TEST(RawTrack, ReportsASingleShortLossAsLost) {
  LockedStand stand(false);
  stand.Move(kPeriodNs);
  stand.Hide();
  CHECK(stand.Told().status == FixStatus::kLost);
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kTracked);
}

TEST(RawTrack, LosesNoneOfAShakenLoadersPairsSeeds1To5) {
  // 2 mm at 17 Hz and brakes hard, as the demo's loader: the gate is no hindrance to real machines.
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Stand stand(seed);
    for (int i = 0; i < 600; ++i) {
      stand.Move(kPeriodNs);
      const double t_s = 0.016 * i, shaking = 2 * 3.14159265 * 17 * t_s;
      stand.truth.PlaceAt(
          {2 + 0.002 * std::sin(shaking), 1 + 0.002 * std::cos(shaking), 20 + 4 * t_s + 0.2 * t_s * t_s},
          {1, 0.002 * std::sin(shaking), 0.1});
      stand.Show();
      CHECK(stand.Told().status == FixStatus::kTracked);
    }
  }
}

TEST_GROUP(FilteredTrack){};

TEST(FilteredTrack, IsNearerToTheTruthWhereMeasurementsArePoorSeeds1To20) {
  double filtered_m2 = 0, raw_m2 = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    LockedStand stand(true, seed);
    stand.sigma_m = {0.005, 0.005, 0.05};
    for (int i = 0; i < 40; ++i) {
      stand.MoveAndShow();
      filtered_m2 += std::pow(ErrorM(stand), 2);
      raw_m2 += (stand.measured.point_b_m - stand.Epicenter()).squaredNorm();
    }
  }
  CHECK(filtered_m2 < 0.5 * raw_m2);
}

TEST(FilteredTrack, BridgesAShortLossWithLessAndLessCertainty) {
  LockedStand stand(true);
  double before_m = 0;
  int bridged = 0;
  for (int i = 0; i < 40; ++i) {
    stand.Move(kPeriodNs);
    stand.Hide();
    if (stand.Told().status == FixStatus::kLost) break;
    CHECK(stand.Told().status == FixStatus::kPredicted);
    const double sigma_m = std::sqrt(stand.Told().epicenter_covariance_m2.trace());
    CHECK(sigma_m > before_m);
    CHECK(ErrorM(stand) < 4 * sigma_m);
    CHECK(stand.states.targets[0].last_seen_ns < stand.now_ns);
    DOUBLES_EQUAL(1.5, (stand.Told().leds_b_m[3] - stand.Told().leds_b_m[0]).norm(), 1e-9);
    before_m = sigma_m;
    ++bridged;
  }
  CHECK(bridged >= 10);
  CHECK(bridged * kPeriodNs <= 500 * kNsPerMs);
  CHECK(stand.Told().epicenter_b_m.isZero());
}

TEST(FilteredTrack, BridgesWhatDoesNotFit) {
  LockedStand stand(true);
  stand.Jump({1, 0, 0});
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kPredicted);
  DOUBLES_EQUAL(1, ErrorM(stand), 0.1);  // where it was expected
  stand.MoveAndShow();
  CHECK(stand.Told().status == FixStatus::kTracked);
  CHECK(ErrorM(stand) < 0.02);
}

TEST(FilteredTrack, KnowsThePlaceAtATimeBetweenAndAfterThePairs) {
  LockedStand stand(true);
  const auto now = stand.tracker.PlaceAt(0, stand.now_ns);
  CHECK(now.has_value());
  CHECK((now->point_b_m - stand.Told().epicenter_b_m).norm() < 1e-9);
  stand.Move(40 * kNsPerMs);
  const auto later = stand.tracker.PlaceAt(0, stand.now_ns);
  CHECK(later.has_value());
  CHECK((later->point_b_m - stand.Epicenter()).norm() <
        4 * std::sqrt(later->covariance.topLeftCorner<3, 3>().trace()));
  CHECK(later->covariance(0, 0) > now->covariance(0, 0));
  CHECK_FALSE(stand.tracker.PlaceAt(0, stand.now_ns - 41 * kNsPerMs).has_value());
  CHECK_FALSE(stand.tracker.PlaceAt(0, stand.now_ns + adit::base::kNsPerS).has_value());
}
