#include "host/calibration.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <vector>

#include "host/calibration_text.h"
#include "tests/support/nees.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_rig.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Calibrate;
using adit::host::Calibration;
using adit::host::CalibrationInput;
using adit::host::StereoBar;
using adit::tests::SyntheticRig;
using adit::tests::WaveBars;
using adit::tests::Waving;
using Eigen::Vector3d;

adit::base::Target Wand() {
  adit::base::Target target;
  target.name = "wand";
  target.leds_m = {0, 0.25, 0.65, 1.5};
  return target;
}

adit::optics::CameraModel Camera(const SyntheticRig& rig) {
  adit::optics::CameraModel camera;
  camera.fu_px = camera.fv_px = rig.focal_px;
  camera.cu_px = rig.cu_px, camera.cv_px = rig.cv_px;
  camera.width_px = 1400, camera.height_px = 1024;
  return camera;
}

StereoBar Measured(const adit::tests::SyntheticBar& bar, double noise_px, std::size_t frame) {
  StereoBar measured;
  measured.mid_exposure_ns = static_cast<adit::base::TimeNs>(frame) * 16'666'667;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity() * noise_px * noise_px;
    measured.left[i] = {bar.left_px[i], bar.left_px[i], covariance};
    measured.right[i] = {bar.right_px[i], bar.right_px[i], covariance};
  }
  return measured;
}

CalibrationInput Waved(const SyntheticRig& rig, const Waving& waving, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  CalibrationInput input{{"rec"}, Camera(rig), Camera(rig), {Wand()}, {}};
  for (const auto& bar : WaveBars(rig, Wand().leds_m, waving, count, random))
    input.bars.push_back(Measured(bar, waving.noise_px, input.bars.size()));
  return input;
}

/// Errors against truth: rotation vector in the right camera's frame, translation.
Eigen::Matrix<double, 6, 1> PoseError(const SyntheticRig& truth, const Calibration& calibration) {
  const Eigen::AngleAxisd turn(calibration.rig.T_r_l.rotation * truth.right_from_left.transpose());
  Eigen::Matrix<double, 6, 1> error;
  error << turn.angle() * turn.axis(), calibration.rig.T_r_l.translation_m - truth.right_translation_m;
  return error;
}

/// A calibration that must succeed.
Calibration MustCalibrate(const CalibrationInput& input) {
  auto calibration = Calibrate(input);
  if (!calibration) FAIL(calibration.error().Line().c_str());
  return *calibration;
}

/// Bars found right: adjusted or held out.
std::size_t RightBars(const Calibration& calibration) {
  return calibration.quality.bars_used + calibration.quality.hold_out.bars.size();
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_GROUP(Calibration) { SyntheticRig rig_ = SyntheticRig::Convergent(9, 35); };

TEST(Calibration, IsExactOnExactBars) {
  Waving waving;
  waving.noise_px = 0;
  auto input = Waved(rig_, waving, 100, 1);
  for (auto& bar : input.bars) {
    for (auto* view : {&bar.left, &bar.right}) {
      for (auto& led : *view) led.covariance_px2 = Eigen::Matrix2d::Identity() * 0.0025;
    }
  }

  const auto calibration = MustCalibrate(input);

  const auto error = PoseError(rig_, calibration);
  DOUBLES_EQUAL(0, error.head<3>().norm(), 1e-8);
  DOUBLES_EQUAL(0, error.tail<3>().norm(), 1e-6);
  LONGS_EQUAL(100, RightBars(calibration));
}

// 40 calibrations of 300 bars: normalised errors have a mean of 6 if the stated covariance is honest. The sum
// of 40 chi-squares of 6 degrees lies in [188, 299] with 99 % (chi-square of 240 degrees).
TEST(Calibration, StatesAnHonestCovariance) {
  double sum = 0;
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    const auto calibration = MustCalibrate(Waved(rig_, {}, 300, seed));
    const auto error = PoseError(rig_, calibration);
    sum += adit::support::Nees(error, calibration.covariance.topLeftCorner<6, 6>());
  }
  CHECK_COMPARE(sum, >, 188);
  CHECK_COMPARE(sum, <, 299);
}

// bounds: 1100 frames of a 0.82 m bar at 0.05 px leave 30 urad of yaw and 0.74 mm of baseline; this bar is
// 1.5 m. One draw may be 2.5 sigma off.
TEST(Calibration, ReachesTheBoundOfAWavedBar) {
  const auto calibration = MustCalibrate(Waved(rig_, {}, 1100, 7));

  const auto error = PoseError(rig_, calibration);
  CHECK_COMPARE(std::abs(error[0]), <, 2.5 * 2e-6);
  CHECK_COMPARE(std::abs(error[1]), <, 2.5 * 30e-6);
  CHECK_COMPARE(std::abs(error[2]), <, 2.5 * 4e-6);
  DOUBLES_EQUAL(rig_.right_translation_m.norm(), calibration.quality.baseline_m, 2.5 * 0.74e-3);
  CHECK_COMPARE(RightBars(calibration), >, 1080);
  DOUBLES_EQUAL(0.05, calibration.quality.rms_px, 0.01);
  DOUBLES_EQUAL(1, calibration.quality.sigma0, 0.05);
  DOUBLES_EQUAL(0, calibration.quality.bar_bias_m, 0.0005);
}

// Every fifth frame holds a wrong pair: the left image of one moment with the right image of another.
TEST(Calibration, SurvivesWrongPairsInAFifthOfTheFrames) {
  for (std::uint64_t seed = 200; seed < 210; ++seed) {
    auto input = Waved(rig_, {}, 300, seed);
    for (std::size_t i = 0; i < input.bars.size(); i += 5)
      input.bars[i].right = input.bars[(i + 7) % input.bars.size()].right;

    const auto calibration = MustCalibrate(input);

    CHECK_COMPARE(RightBars(calibration), >=, 230);
    CHECK_COMPARE(RightBars(calibration), <=, 240);
    const auto error = PoseError(rig_, calibration);
    CHECK_COMPARE(adit::support::Nees(error, calibration.covariance.topLeftCorner<6, 6>()), <,
                  22.5);  // 99.9 % of chi2(6)
  }
}

TEST(Calibration, PicksTheRightOneOfSeveralCandidatesOfAFrame) {
  auto input = Waved(rig_, {}, 200, 31);
  auto clutter = Waved(rig_, {}, 200, 32);
  for (std::size_t i = 0; i < 100; ++i) {
    StereoBar wrong = input.bars[i];
    wrong.right = clutter.bars[i].right;
    input.bars.push_back(wrong);
  }

  const auto calibration = MustCalibrate(input);

  LONGS_EQUAL(200, calibration.quality.bars_seen);
  CHECK_COMPARE(RightBars(calibration), >=, 195);
  CHECK_COMPARE(RightBars(calibration), <=, 200);
}

// The detector's covariance is a model: if it promises twice too much, sigma0 says so and the pose's
// covariance is widened by it.
TEST(Calibration, WidensItsCovarianceWhenCentroidsAreWorseThanPromised) {
  const auto fair = MustCalibrate(Waved(rig_, {}, 300, 41));
  auto input = Waved(rig_, {}, 300, 41);
  for (auto& bar : input.bars) {
    for (auto* view : {&bar.left, &bar.right}) {
      for (auto& led : *view) led.covariance_px2 /= 4;
    }
  }

  const auto hopeful = MustCalibrate(input);

  DOUBLES_EQUAL(2, hopeful.quality.sigma0, 0.1);
  DOUBLES_EQUAL(1, hopeful.quality.sigma_rad.y() / fair.quality.sigma_rad.y(), 0.1);
}

TEST(Calibration, WorksForParallelCamerasAndForFarBars) {
  const SyntheticRig parallel = SyntheticRig::Convergent(3, 1e6);
  Waving far;
  far.nearest_m = 30, far.farthest_m = 80;
  for (const auto& [rig, waving] : {std::pair{parallel, Waving{}}, std::pair{rig_, far}}) {
    const auto calibration = MustCalibrate(Waved(rig, waving, 400, 51));
    CHECK_COMPARE(RightBars(calibration), >, 380);
    const auto error = PoseError(rig, calibration);
    CHECK_COMPARE(adit::support::Nees(error, calibration.covariance.topLeftCorner<6, 6>()), <, 22.5);
  }
}

TEST(Calibration, GivesTheSameDigitsTwice) {
  const auto first = MustCalibrate(Waved(rig_, {}, 200, 61));
  const auto second = MustCalibrate(Waved(rig_, {}, 200, 61));
  STRCMP_EQUAL(FormatCalibration(first).c_str(), FormatCalibration(second).c_str());
}

TEST(Calibration, RefusesNoBarsAndTooFew) {
  const auto none = Calibrate(Waved(rig_, {}, 0, 71));
  const auto few = Calibrate(Waved(rig_, {}, 19, 72));
  CHECK_FALSE(none);
  CHECK_FALSE(few);
  CHECK(Contains(none.error().Line(), "rec: 0 bars identified"));
  CHECK(Contains(few.error().Line(), "rec: 19 bars"));
  LONGS_EQUAL(1, few.error().ExitCode());
}

TEST(Calibration, RefusesPairsThatHaveNothingInCommon) {
  auto input = Waved(rig_, {}, 200, 81);
  const auto other = Waved(rig_, {}, 200, 82);
  for (std::size_t i = 0; i < input.bars.size(); ++i) input.bars[i].right = other.bars[i].right;
  const auto calibration = Calibrate(input);
  CHECK_FALSE(calibration);
  CHECK(Contains(calibration.error().Line(), "agree on one epipolar geometry"));
}

TEST(Calibration, RefusesABarThatStaysInOnePlace) {
  auto input = Waved(rig_, {}, 1, 91);
  std::mt19937_64 random(92);
  const StereoBar still = input.bars[0];
  for (std::size_t i = 1; i < 200; ++i) {
    StereoBar bar = still;
    bar.mid_exposure_ns += static_cast<adit::base::TimeNs>(i) * 16'666'667;
    for (auto* view : {&bar.left, &bar.right}) {
      for (auto& led : *view)
        led.ideal_px += 0.05 * Eigen::Vector2d(adit::tests::Gauss(random), adit::tests::Gauss(random));
    }
    input.bars.push_back(bar);
  }
  const auto calibration = Calibrate(input);
  CHECK_FALSE(calibration);
  CHECK(Contains(calibration.error().Line(), "'s image"));
}

TEST(Calibration, RefusesExchangedCameras) {
  auto input = Waved(rig_, {}, 200, 95);
  for (auto& bar : input.bars) std::swap(bar.left, bar.right);
  const auto calibration = Calibrate(input);
  CHECK_FALSE(calibration);
  CHECK(Contains(calibration.error().Line(), "exchange the cameras"));
}

// An image mirrored by a prism or a wrong readout setting fits no rigid pose.
TEST(Calibration, RefusesAMirroredImage) {
  auto input = Waved(rig_, {}, 200, 96);
  for (auto& bar : input.bars) {
    for (auto& led : bar.right) led.ideal_px.x() = 1399 - led.ideal_px.x();
  }
  const auto calibration = Calibrate(input);
  CHECK_FALSE(calibration);
  CHECK(Contains(calibration.error().Line(), "mirrored"));
}

TEST(Calibration, NamesACalibrationByItsContent) {
  auto first = MustCalibrate(Waved(rig_, {}, 100, 97));
  auto second = first;
  second.rig.T_r_l.translation_m.x() += 1e-9;
  const std::string text = FormatCalibration(first), other = FormatCalibration(second);
  const auto id = [](const std::string& file) { return file.substr(file.find("calibration_id"), 26); };
  CHECK_FALSE(id(text) == id(other));
  CHECK(Contains(text, "quality:"));
}

// Every tenth bar is held out. Half a pixel across the epipolar lines passes the search for them, but fits no
// bar.
TEST(Calibration, NamesWrongPairsAmongTheBarsHeldOut) {
  auto input = Waved(rig_, {}, 200, 98);
  for (std::size_t i = 9; i < input.bars.size(); i += 10) {
    for (auto& led : input.bars[i].left) led.raw_px.y() += 0.5, led.ideal_px.y() += 0.5;
  }
  const auto calibration = MustCalibrate(input);
  std::size_t named = 0;
  for (const auto& pair : calibration.wrong) {
    named += Contains(pair.reason, "held out") ? 1 : 0;
    LONGS_EQUAL(9, pair.mid_exposure_ns / 16'666'667 % 10);
  }
  LONGS_EQUAL(20, named);
  CHECK(Contains(WrongPairs(calibration, input), "held out, fits no place of the bar"));
  LONGS_EQUAL(180, RightBars(calibration));
}

TEST(Calibration, TheRigFileKeepsTheCovariance) {
  const adit::tests::ScratchFolder folder;
  const auto calibration = MustCalibrate(Waved(rig_, {}, 100, 99));
  const std::string path = folder.Write("rig.yaml", FormatCalibration(calibration));
  const auto rig = adit::optics::LoadRig(path);
  const auto covariance = adit::optics::LoadRigCovariance(path);
  CHECK_TRUE(rig);
  CHECK_TRUE(covariance);
  CHECK(covariance->has_value());
  const Eigen::VectorXd sigma = calibration.covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < sigma.size(); ++i) {
    for (int j = 0; j < sigma.size(); ++j)
      DOUBLES_EQUAL(calibration.covariance(i, j), (**covariance)(i, j), 1e-7 * sigma[i] * sigma[j]);
  }
  DOUBLES_EQUAL(0, (rig->T_r_l.translation_m - calibration.rig.T_r_l.translation_m).norm(), 1e-9);
}

TEST(Calibration, SaysWhereToWaveNext) {
  const auto calibration = MustCalibrate(Waved(rig_, {}, 100, 100));
  CHECK_FALSE(calibration.quality.gaps.empty());
  const std::string words = calibration.quality.gaps.front().Words();
  CHECK(Contains(Summary(calibration), words));
  CHECK(Contains(FormatCalibration(calibration), "wave_next: \"" + words + "\""));
}
