#include "firmware/publish/epoch.h"

#include <cmath>
#include <limits>

#include "tests/unit/firmware/publish/fixes.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

constexpr base::TimeNs kSoonNs = kExposureNs + 20 * base::kNsPerMs;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Epoch Make(const georef::GeoFix& fix, const BoxCondition& box = GoodBox(), const EpochRules& rules = {},
           base::TimeNs now_ns = kSoonNs) {
  return MakeEpoch(&fix, box, rules, now_ns);
}

void CheckNothingToTell(const Epoch& epoch) {
  LONGS_EQUAL(static_cast<int>(Validity::kInvalid), static_cast<int>(epoch.validity));
  CHECK_FALSE(epoch.position_s_m.has_value());
  CHECK_FALSE(epoch.sigma_horizontal_m.has_value());
  CHECK_FALSE(epoch.sigma_vertical_m.has_value());
  CHECK_FALSE(epoch.sigma_ok);
}

}  // namespace

TEST_GROUP(Epoch){};

TEST(Epoch, ATrackedTargetIsValid) {
  const Epoch epoch = Make(TrackedFix());
  CHECK(epoch.validity == Validity::kValid);
  CHECK(epoch.state == BoxState::kTrack);
  DOUBLES_EQUAL(20.2, (*epoch.position_s_m)[1], 0);
  DOUBLES_EQUAL(0.005, *epoch.sigma_horizontal_m, 1e-12);
  DOUBLES_EQUAL(0.002, *epoch.sigma_vertical_m, 1e-12);
  LONGS_EQUAL(0x1234, epoch.number);
  LONGS_EQUAL(0, epoch.faults);
}

TEST(Epoch, NoMachineSteersByARecoveredTarget) {
  georef::GeoFix fix = TrackedFix();
  fix.state.points.status = stereo::FixStatus::kRecovered;
  const Epoch epoch = Make(fix);
  CHECK(epoch.validity == Validity::kDegraded);
  CHECK(epoch.position_s_m.has_value());
}

TEST(Epoch, ACalibrationInDoubtDegradesAndKeepsThePosition) {
  BoxCondition box = GoodBox();
  box.faults = kFaultResidual;
  const Epoch epoch = Make(TrackedFix(), box);
  CHECK(epoch.validity == Validity::kDegraded);
  CHECK(epoch.state == BoxState::kDegraded);
  CHECK(epoch.position_s_m.has_value());
  LONGS_EQUAL(1 << 6, epoch.faults);
}

TEST(Epoch, ABodysAttitudeGoesWithItsPosition) {
  georef::GeoFix fix = TrackedFix();
  CHECK_FALSE(Make(fix).heading_rad.has_value());  // a bar has none
  fix.attitude = georef::Attitude{1.5, -0.1, 0.2};
  const Epoch epoch = Make(fix);
  DOUBLES_EQUAL(1.5, *epoch.heading_rad, 0);
  DOUBLES_EQUAL(-0.1, *epoch.pitch_rad, 0);
  DOUBLES_EQUAL(0.2, *epoch.roll_rad, 0);
  CHECK_FALSE(Make(fix, GoodBox(), {}, kSoonNs + base::kNsPerS).heading_rad.has_value());
  CHECK_FALSE(AsOf(epoch, kSoonNs + base::kNsPerS).roll_rad.has_value());
}

TEST(Epoch, SigmaAboveItsLimitDegradesInEitherDirection) {
  georef::GeoFix horizontal = TrackedFix();
  horizontal.covariance_s_m2(0, 0) = 0.0201 * 0.0201;
  CHECK(Make(horizontal).validity == Validity::kDegraded);
  CHECK(Make(horizontal).state == BoxState::kDegraded);
  CHECK(Make(horizontal).position_s_m.has_value());
  georef::GeoFix vertical = TrackedFix();
  vertical.covariance_s_m2(2, 2) = 0.0201 * 0.0201;
  CHECK(Make(vertical).validity == Validity::kDegraded);
}

TEST(Epoch, APredictedTargetIsDegradedHoweverSmallItsSigma) {
  georef::GeoFix fix = TrackedFix();
  fix.state.points.status = stereo::FixStatus::kPredicted;
  CHECK(Make(fix).validity == Validity::kDegraded);
}

TEST(Epoch, ALostTargetHasNothingToTellButItsTime) {
  georef::GeoFix fix = TrackedFix();
  fix.state.points.status = stereo::FixStatus::kLost;
  CheckNothingToTell(Make(fix));
  CHECK(Make(fix).state == BoxState::kLost);
  CHECK(kExposureNs == Make(fix).mid_exposure_ns);
  fix.state.last_seen_ns = base::kNever;
  CHECK(Make(fix).state == BoxState::kSearch);
}

TEST(Epoch, NoFixIsSearchAndBeforeTheFirstPairInit) {
  BoxCondition box = GoodBox();
  CheckNothingToTell(MakeEpoch(nullptr, box, {}, kSoonNs));
  CHECK(MakeEpoch(nullptr, box, {}, kSoonNs).state == BoxState::kSearch);
  box.initialised = false;
  CHECK(MakeEpoch(nullptr, box, {}, kSoonNs).state == BoxState::kInit);
}

TEST(Epoch, AnOldPositionIsNeverTold) {
  const EpochRules rules;
  const base::TimeNs limit_ns = kExposureNs + rules.age_limit_ns;
  CHECK(Make(TrackedFix(), GoodBox(), rules, limit_ns).validity == Validity::kValid);
  const Epoch old = Make(TrackedFix(), GoodBox(), rules, limit_ns + 1);
  CheckNothingToTell(old);
  CHECK(old.state == BoxState::kLost);
}

TEST(Epoch, AnExposureInTheFutureIsNotTold) {
  CHECK(Make(TrackedFix(), GoodBox(), {}, kExposureNs - kClockSlackNs).validity == Validity::kValid);
  CheckNothingToTell(Make(TrackedFix(), GoodBox(), {}, kExposureNs - kClockSlackNs - 1));
}

TEST(Epoch, AnUndatedFixIsNotTold) {
  georef::GeoFix fix = TrackedFix();
  fix.state.mid_exposure_ns = base::kNever;
  CheckNothingToTell(Make(fix));
}

TEST(Epoch, SimulationIsNeverValid) {
  BoxCondition box = GoodBox();
  box.simulation = true;
  georef::GeoFix fix = TrackedFix();
  CHECK(Make(fix, box).validity == Validity::kSimulated);
  CHECK(Make(fix, box).state == BoxState::kSimulation);
  fix.state.points.status = stereo::FixStatus::kPredicted;
  CHECK(Make(fix, box).validity == Validity::kSimulated);
  fix.state.points.status = stereo::FixStatus::kLost;
  CheckNothingToTell(Make(fix, box));
  CHECK(Make(fix, box).state == BoxState::kSimulation);
}

TEST(Epoch, NumbersThatAreNotFiniteAreNotTold) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (int axis = 0; axis < 3; ++axis) {
      georef::GeoFix fix = TrackedFix();
      fix.position_s_m[axis] = bad;
      CheckNothingToTell(Make(fix));
      georef::GeoFix blurred = TrackedFix();
      blurred.covariance_s_m2(axis, axis) = bad;
      CheckNothingToTell(Make(blurred));
    }
  }
}

TEST(Epoch, ANegativeVarianceIsNotTold) {
  georef::GeoFix fix = TrackedFix();
  fix.covariance_s_m2(2, 2) = -1e-9;
  CheckNothingToTell(Make(fix));
}

TEST(Epoch, APlaceThatDoesNotFitTheWireIsNotTold) {
  EpochRules rules;
  rules.origin_s_m = {2'600'000, 1'200'000, 400};
  georef::GeoFix fix = TrackedFix();
  CheckNothingToTell(Make(fix, GoodBox(), rules));
  fix.position_s_m = Eigen::Vector3d(2'600'000 + 214'748.3647, 1'200'000, 400);
  CHECK(Make(fix, GoodBox(), rules).validity == Validity::kValid);
  fix.position_s_m.x() += 0.0002;
  CheckNothingToTell(Make(fix, GoodBox(), rules));
  fix.position_s_m.x() = 2'600'000 - 214'748.3649;
  CheckNothingToTell(Make(fix, GoodBox(), rules));
}

TEST(Epoch, WithoutAGeoreferenceTheFaultSaysSo) {
  BoxCondition box = GoodBox();
  box.georeferenced = false;
  CHECK(Make(TrackedFix(), box).validity == Validity::kValid);
  LONGS_EQUAL(1 << 5, Make(TrackedFix(), box).faults);
}

TEST(Epoch, AnOriginWithoutAGeoreferenceIsNotApplied) {
  BoxCondition box = GoodBox();
  box.georeferenced = false;
  EpochRules rules;
  rules.origin_s_m = {0, 0, 5};
  CheckNothingToTell(Make(TrackedFix(), box, rules));
}

TEST(Epoch, AFaultyCameraStopsAtOnce) {
  for (const std::uint16_t fault : {kFaultCameraA, kFaultCameraB, kFaultInternal}) {
    BoxCondition box = GoodBox();
    box.faults = fault;
    CheckNothingToTell(Make(TrackedFix(), box));
    CHECK(Make(TrackedFix(), box).state == BoxState::kFault);
  }
  BoxCondition warm = GoodBox();
  warm.faults = kFaultTemperature;
  CHECK(Make(TrackedFix(), warm).validity == Validity::kValid);
}

TEST(Epoch, ABoxInServiceDoesNotSteer) {
  BoxCondition box = GoodBox();
  box.service = true;
  CHECK(Make(TrackedFix(), box).validity == Validity::kDegraded);
  CHECK(Make(TrackedFix(), box).state == BoxState::kService);
}

TEST(Epoch, TurnsInvalidWhenItGrowsOldBetweenMakingAndTelling) {
  const Epoch epoch = Make(TrackedFix());
  CHECK(AsOf(epoch, kExposureNs + epoch.age_limit_ns).validity == Validity::kValid);
  const Epoch later = AsOf(epoch, kExposureNs + epoch.age_limit_ns + 1);
  CheckNothingToTell(later);
  CHECK(later.state == BoxState::kLost);
  LONGS_EQUAL(epoch.number, later.number);
}

TEST(Epoch, AgeIsZeroWithinTheClocksSlackAndUnknownBeforeIt) {
  const Epoch epoch = Make(TrackedFix());
  LONGS_EQUAL(0, *AgeAt(epoch, kExposureNs - kClockSlackNs));
  CHECK_FALSE(AgeAt(epoch, kExposureNs - kClockSlackNs - 1).has_value());
  CHECK_FALSE(AgeAt(Epoch{}, kExposureNs).has_value());
  CHECK_FALSE(AgeAt(epoch, base::kNever).has_value());
}

}  // namespace adit::publish
