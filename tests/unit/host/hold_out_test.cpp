#include "host/hold_out.h"

#include <Eigen/Geometry>

#include "host/simulated_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::BundleSetting;
using adit::host::CalibrationDraw;
using adit::host::CalibrationPlan;
using adit::host::HoldOut;
using adit::optics::RigCovariance;

/// Cameras and bar as their files say.
CalibrationDraw ExactDraw(std::size_t bars, std::uint64_t seed) {
  CalibrationPlan plan;
  plan.bars = bars;
  plan.noise_px = 0.03;
  plan.intrinsics = {0, 0, 0};
  plan.bar_sigma_m = 0;
  return adit::host::Draw(plan, seed);
}

BundleSetting ExactSettingOf(const CalibrationDraw& draw) {
  return {draw.input.left, draw.input.right, {}, {}, draw.input.targets, 0, 1};
}

HoldOut TestAll(const CalibrationDraw& draw, const adit::optics::Rig& rig) {
  return TestHoldOut(ExactSettingOf(draw), rig, RigCovariance::Zero(), draw.input.bars);
}

/// Probability that chi-square of an even number of degrees of freedom exceeds `chi2`: that of fewer than
/// half as many events of a Poisson process of mean chi2 / 2.
double ExceededBy(double chi2, int degrees_of_freedom) {
  double term = std::exp(-chi2 / 2), sum = 0;
  for (int i = 0; i < degrees_of_freedom / 2; ++i) {
    sum += term;
    term *= chi2 / 2 / (i + 1);
  }
  return sum;
}

}  // namespace

TEST_GROUP(HoldOut){};

TEST(HoldOut, PredictsTheLengthErrorsOfATrueRig) {
  const CalibrationDraw draw = ExactDraw(400, 1);
  const HoldOut held = TestAll(draw, draw.rig.AsRig());
  LONGS_EQUAL(400, held.bars.size() + held.misfits.size());
  CHECK_COMPARE(held.misfits.size(), <=, 3);  // one in a thousand by chance
  // 400 normal deviates: their rms is 1 within 3.5 %, 1 sigma; that of 4400 residuals within 1.1 %.
  DOUBLES_EQUAL(1, held.ratio, 3 * 0.035);
  DOUBLES_EQUAL(1, held.reprojection, 3 * 0.011);
}

TEST(HoldOut, ShowsARigThatTurned) {
  const CalibrationDraw draw = ExactDraw(100, 2);
  adit::optics::Rig turned = draw.rig.AsRig();
  turned.T_r_l.rotation = Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitY()) * turned.T_r_l.rotation;
  const HoldOut held = TestAll(draw, turned);
  CHECK_COMPARE(held.bars.size(), >, 0);
  CHECK_COMPARE(held.ratio, >, held.RatioMax());
}

TEST(HoldOut, NamesAWrongPair) {
  CalibrationDraw draw = ExactDraw(50, 3);
  draw.input.bars[17].right = draw.input.bars[18].right;
  const HoldOut held = TestAll(draw, draw.rig.AsRig());
  LONGS_EQUAL(1, held.misfits.size());
  CHECK(KeyOf(held.misfits[0]) == KeyOf(draw.input.bars[17]));
  for (const auto& bar : held.bars) CHECK_FALSE(bar.key == KeyOf(draw.input.bars[17]));
}

TEST(HoldOut, PlacesABarWhereItIs) {
  CalibrationDraw draw = ExactDraw(20, 4);
  for (std::size_t k = 0; k < draw.bars.size(); ++k) {
    const auto seen = Seen(draw.rig, draw.bars[k], draw.input.targets[0].leds_m);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      draw.input.bars[k].left[i].raw_px = seen[i].head<2>();
      draw.input.bars[k].right[i].raw_px = seen[i].tail<2>();
    }
    const auto fitted = FitBar(ExactSettingOf(draw), draw.rig.AsRig(), draw.input.bars[k]);
    CHECK(fitted.has_value());
    const Eigen::Vector3d centre_m = draw.bars[k].led1_m + (0.25 + 0.53 + 0.82) / 4 * draw.bars[k].direction;
    DOUBLES_EQUAL(0, (fitted->place.centre_l_m - centre_m).norm(), 1e-6);
    DOUBLES_EQUAL(0, (fitted->place.direction_l - draw.bars[k].direction).norm(), 1e-6);
    DOUBLES_EQUAL(0, fitted->chi2, 1e-6);
  }
}

TEST(HoldOut, ChanceExceedsItsLimitOnceInAThousand) {
  HoldOut held;
  DOUBLES_EQUAL(0, held.RatioMax(), 0);
  for (const int bars : {2, 10, 30, 100, 400}) {
    held.bars.resize(static_cast<std::size_t>(bars));
    const double chance = ExceededBy(bars * held.RatioMax() * held.RatioMax(), bars);
    CHECK_COMPARE(chance, >, 0.8e-3);
    CHECK_COMPARE(chance, <, 1.2e-3);
  }
}
