// The watch against traffic with a known turn of the right camera.
#include "firmware/watch/watch.h"

#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/watch/traffic.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::watch::Finding;
using adit::watch::Verdict;
using adit::watch::Watch;
using adit::watch::WatchOptions;
using adit::watch_tests::Traffic;
using adit::watch_tests::TrafficOptions;
using Eigen::Vector3d;

constexpr double kMicro = 1e-6;

/// A calibration as good as they come (bounds 2.5).
adit::watch::MotionMatrix CalibrationCovariance() {
  adit::watch::MotionMatrix covariance = adit::watch::MotionMatrix::Zero();
  covariance.diagonal() << 4e-12, 9e-10, 16e-12, 1e-6, 1e-6, 1e-6;
  return covariance;
}

/// Noise A at an LED peak of 200 DN, for which the ten microradians are promised.
constexpr double kNoiseAPx = 0.0084;
/// The same information as 60 pairs a second of `noise_px`, at a sixth of the cost.
constexpr double kSparseHz = 10;
TrafficOptions Sparse(double noise_px = 0.02) {
  TrafficOptions options;
  options.rate_hz = kSparseHz;
  options.noise_px = noise_px / std::sqrt(60 / kSparseHz);
  return options;
}

/// A watch and its traffic.
struct Stand {
  Traffic traffic;
  Watch watch;

  int learn_s;

  Stand(const TrafficOptions& traffic_options, unsigned seed, int seconds = WatchOptions{}.learn_s)
      : traffic(traffic_options, seed),
        watch(traffic.Rig(), Traffic::Targets(), Options(traffic, traffic_options, seconds),
              CalibrationCovariance()),
        learn_s(seconds) {}

  static WatchOptions Options(const Traffic& traffic, const TrafficOptions& traffic_options, int seconds) {
    WatchOptions options;
    options.rate_hz = traffic_options.rate_hz, options.learn_s = seconds;
    if (traffic_options.with_lights) options.lights_b_m = traffic.BelievedLights();
    return options;
  }
  const Finding& Found() const { return watch.Latest(); }
  int Pairs(double seconds) const { return static_cast<int>(std::lround(seconds * Hz())); }
  /// Drives on; returns after how many seconds the verdict was first `verdict`, or nothing.
  std::optional<double> Drive(double seconds, Verdict verdict = Verdict::kChanged) {
    std::optional<double> first_s;
    for (int i = 0; i < Pairs(seconds); ++i) {
      watch.Add(traffic.Next());
      if (!first_s && Found().verdict == verdict) first_s = (i + 1) / Hz();
    }
    return first_s;
  }
  /// Until the references are there.
  void Learn() { Drive(learn_s + 2); }
  double Hz() const { return traffic.RateHz(); }
};

Vector3d TurnOf(const Finding& finding) { return Vector3d(finding.turn_rad.data()); }

}  // namespace

TEST_GROUP(Watch){};

TEST(Watch, FindsAYawOfTenMicroradiansWithin30SecondsOfTraffic) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    Stand stand(Sparse(seed <= 2 ? kNoiseAPx : 0.02), seed);
    stand.Learn();
    CHECK(stand.Found().verdict == Verdict::kHolds);
    stand.traffic.TurnRight({0, 10 * kMicro, 0});
    CHECK(stand.Drive(30).has_value());
    const Finding& found = stand.Found();
    DOUBLES_EQUAL(10 * kMicro, found.turn_rad[1], 4 * found.sigma_rad[1]);
    CHECK(found.sigma_rad[1] < 2 * kMicro);
  }
}

TEST(Watch, FindsItAtTheCamerasOwnRate) {
  Stand stand(TrafficOptions{}, 7);
  stand.Learn();
  CHECK(stand.Found().verdict == Verdict::kHolds);
  stand.traffic.TurnRight({0, -10 * kMicro, 0});
  CHECK(stand.Drive(30).has_value());
  DOUBLES_EQUAL(-10 * kMicro, stand.Found().turn_rad[1], 4 * stand.Found().sigma_rad[1]);
}

TEST(Watch, IsQuietForAQuarterOfAnHourWithoutAChange) {
  Stand stand(Sparse(), 8);
  CHECK(!stand.Drive(900).has_value());
  CHECK(stand.Found().verdict == Verdict::kHolds);
  CHECK_EQUAL(0U, stand.Found().wrong);
}

TEST(Watch, TheStatedSigmaOfTheTurnIsTrue) {
  constexpr int kRuns = 24;
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  for (unsigned seed = 100; seed < 100 + kRuns; ++seed) {
    TrafficOptions options = Sparse(kNoiseAPx);
    options.phase_bias_px = WatchOptions{}.bias_px;
    Stand stand(options, seed, 60);
    adit::support::SyntheticScene draw(adit::support::ToedInRig(), seed + 1000);
    const auto random = [&draw](double sigma) -> Vector3d {
      return sigma * Vector3d(draw.Gauss(), draw.Gauss(), draw.Gauss());
    };
    stand.Learn();
    // What the options allow for happens, as strongly as they say.
    const Vector3d turn_rad = random(5 * kMicro);
    stand.traffic.TurnRight(turn_rad + random(WatchOptions{}.allowance_rad));
    stand.traffic.ShiftRight(random(WatchOptions{}.shift_sigma_m));
    stand.Drive(Watch::kWindowS + 2);
    const Vector3d sigma_rad(stand.Found().sigma_rad.data());
    squares += ((TurnOf(stand.Found()) - turn_rad).array() / sigma_rad.array()).square();
  }
  // Chi-square of 24 degrees of freedom: 99 % lie between 9.89 and 45.56. Roll alone is stated up to twice
  // too large: it rests on the LEDs' heights, which hardly move over the pixels while the bar drives and
  // weaves, so that a view states their whole bias, though few of the views together share it.
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(squares[axis] < 45.56);
    CHECK(squares[axis] > (axis == 2 ? 9.89 / 4 : 9.89));
  }
}

TEST(Watch, RecoversTurnsAboutEveryAxisWithoutNoise) {
  for (int axis = 0; axis < 3; ++axis) {
    TrafficOptions options = Sparse();
    options.noise_px = 1e-4;
    Stand stand(options, 9);
    stand.Learn();
    const Vector3d turn_rad = 50 * kMicro * Vector3d::Unit(axis);
    stand.traffic.TurnRight(turn_rad);
    stand.Drive(Watch::kWindowS + 2);
    DOUBLES_EQUAL(0, (TurnOf(stand.Found()) - turn_rad).norm(), kMicro);
  }
}

TEST(Watch, ABarOfAnotherLengthThanItsModelIsNoTurn) {
  Stand stand(Sparse(), 10);
  stand.traffic.Stretch(1e-4, -1e-4);
  CHECK(!stand.Drive(WatchOptions{}.learn_s + 120).has_value());
  CHECK(stand.Found().verdict == Verdict::kHolds);
  stand.traffic.TurnRight({0, 10 * kMicro, 0});
  CHECK(stand.Drive(30).has_value());
}

TEST(Watch, ParkedBarsAreNoTurnAtFiveTimesTheStatedBias) {
  // At eight times, 0.02 px, three of thirteen seeds call a turn: a detection that is biased so much has to
  // say so in bias_px.
  for (const unsigned seed : {11U, 12U, 13U}) {
    TrafficOptions options = Sparse();
    options.phase_bias_px = 5 * WatchOptions{}.bias_px;
    Stand stand(options, seed);
    stand.Learn();
    stand.Drive(7 * (seed - 10));
    stand.traffic.Park();
    CHECK(!stand.Drive(120).has_value());
  }
}

TEST(Watch, ARigThatWasKnockedBeforeTheStartIsFoundAgainstTheCalibration) {
  Stand stand(Sparse(), 14);
  stand.traffic.TurnRight({0, 250 * kMicro, 0});
  const auto first_s = stand.Drive(60);
  CHECK(first_s.has_value());
  CHECK(*first_s <= 30);
  DOUBLES_EQUAL(250 * kMicro, stand.Found().turn_rad[1], 4 * stand.Found().sigma_rad[1]);
}

TEST(Watch, HoldsAgainWhenTheCameraHasTurnedBack) {
  Stand stand(Sparse(), 15);
  stand.Learn();
  stand.traffic.TurnRight({0, 30 * kMicro, 0});
  CHECK(stand.Drive(30).has_value());
  stand.Drive(60);
  CHECK(stand.Found().verdict == Verdict::kChanged);  // it stays as long as the turn does
  stand.traffic.TurnRight({1e-12, 0, 0});
  CHECK(stand.Drive(Watch::kWindowS + 2, Verdict::kHolds).has_value());
}

TEST(Watch, WithoutTargetsNothingIsConcluded) {
  Stand stand(Sparse(), 16);
  adit::stereo::PointSet empty = stand.traffic.Next();
  for (auto& points : empty.targets) points.status = adit::stereo::FixStatus::kRecovered;
  for (int i = 0; i < stand.Pairs(60); ++i) stand.watch.Add(empty);
  DOUBLES_EQUAL(0, stand.Found().tracked_s, 0);
  CHECK(stand.Found().verdict == Verdict::kLearning);
}

TEST(Watch, AllocatesNothingPerPair) {
  Stand stand(Sparse(), 17);
  const adit::stereo::PointSet& set = stand.traffic.Next();
  const std::uint64_t before = adit::support::AllocationCount();
  for (int i = 0; i < stand.Pairs(40); ++i) stand.watch.Add(set);
  CHECK_EQUAL(before, adit::support::AllocationCount());
  CHECK(stand.Found().tracked_s > 39);
}

TEST(Watch, AViewThatNoMotionExplainsIsLeftOut) {
  Stand stand(Sparse(), 18);
  const adit::stereo::PointSet& set = stand.traffic.Next();
  // A lamp in place of LED 2, in the left image.
  adit::detect::BlobSet wrong = *set.left->blob_set;
  wrong.blobs[set.targets[0].blobs[0][1]].ideal_px.y() += 1;
  adit::identify::SightingSet left = *set.left;
  left.blob_set = &wrong;
  adit::stereo::PointSet false_set = set;
  false_set.left = &left;
  const auto views = adit::stereo::MakeViews(stand.traffic.Rig());
  const auto target = Traffic::Targets()[0];
  constexpr double kBiasPx = 0.004, kChiSquareMax = 100;
  adit::watch::BarView good, bad;
  CHECK(good.Add(views, target, set, set.targets[0]));
  CHECK(good.Read(views, target, kBiasPx, kChiSquareMax).has_value());
  CHECK(bad.Add(views, target, false_set, set.targets[0]));
  CHECK(!bad.Read(views, target, kBiasPx, kChiSquareMax).has_value());
}

TEST_GROUP(ReferenceLights){static TrafficOptions Lit(int bars){TrafficOptions options = Sparse();
options.bars = bars;
options.with_lights = true;
return options;
}
}
;

TEST(ReferenceLights, FindAYawWithoutAnyTraffic) {
  for (const unsigned seed : {20U, 21U, 22U}) {
    Stand stand(Lit(0), seed, 60);
    stand.Learn();
    CHECK(stand.Found().verdict == Verdict::kHolds);
    CHECK(!stand.Drive(60).has_value());
    stand.traffic.TurnRight({0, -10 * kMicro, 0});
    CHECK(stand.Drive(30).has_value());
    stand.Drive(Watch::kWindowS);
    DOUBLES_EQUAL(-10 * kMicro, stand.Found().turn_rad[1], 4 * stand.Found().sigma_rad[1]);
    CHECK(stand.Found().sigma_rad[1] < 2 * kMicro);
  }
}

TEST(ReferenceLights, MakeTheTurnMoreCertainThanTrafficAlone) {
  Stand lit(Lit(2), 23, 60), dark(Sparse(), 23, 60);
  for (Stand* stand : {&lit, &dark}) {
    stand->Learn();
    stand->traffic.TurnRight({5 * kMicro, -20 * kMicro, 10 * kMicro});
    stand->Drive(Watch::kWindowS + 2);
    for (int axis = 0; axis < 3; ++axis)
      DOUBLES_EQUAL((Vector3d(5, -20, 10) * kMicro)[axis], TurnOf(stand->Found())[axis],
                    4 * stand->Found().sigma_rad[static_cast<std::size_t>(axis)]);
  }
  CHECK(lit.Found().sigma_rad[1] < 0.9 * dark.Found().sigma_rad[1]);
}

TEST(ReferenceLights, ARigThatSwaysAsAWholeHasNotTurned) {
  Stand stand(Lit(0), 24, 60);
  stand.Learn();
  stand.traffic.Sway(Vector3d(200, -300, 400) * kMicro, Vector3d(0.5e-3, -1e-3, 1e-3));
  CHECK(!stand.Drive(60).has_value());
  CHECK_EQUAL(0U, stand.Found().wrong);
}

TEST(ReferenceLights, TheirSigmaIsTrueWhileTheRigSways) {
  constexpr int kRuns = 24;
  double squares = 0;
  for (unsigned seed = 300; seed < 300 + kRuns; ++seed) {
    Stand stand(Lit(0), seed, 60);
    adit::support::SyntheticScene draw(adit::support::ToedInRig(), seed + 1000);
    const auto random = [&draw](double sigma) -> Vector3d {
      return sigma * Vector3d(draw.Gauss(), draw.Gauss(), draw.Gauss());
    };
    stand.Learn();
    stand.traffic.Sway(random(100 * kMicro), random(adit::watch::ReferenceLights::kSwayM));
    stand.traffic.ShiftRight(random(WatchOptions{}.shift_sigma_m));
    stand.Drive(Watch::kWindowS + 2);
    squares += std::pow(stand.Found().turn_rad[1] / stand.Found().sigma_rad[1], 2);
  }
  // Chi-square of 24 degrees of freedom: 99.5 % lie below 45.56. The air's bias is allowed for and not drawn,
  // so there is no lower limit.
  CHECK(squares < 45.56);
}

TEST(ReferenceLights, OneThatIsHalfHiddenIsLeftOut) {
  Stand stand(Lit(0), 25, 60);
  stand.Learn();
  stand.traffic.Do({1, Vector3d::Zero(), 0.5, 0.3});
  CHECK(!stand.Drive(60).has_value());
  CHECK_EQUAL(0U, stand.Found().wrong);
  stand.traffic.TurnRight({0, 10 * kMicro, 0});
  CHECK(stand.Drive(30).has_value());
}

TEST(ReferenceLights, OneThatWasKnockedIsNoTurn) {
  Stand stand(Lit(0), 26, 60);
  stand.Learn();
  stand.traffic.Do({0, Vector3d(0.01, 0.01, 0), 1, 0});
  CHECK(!stand.Drive(60).has_value());
  CHECK(stand.Found().wrong > 50);
}
