// The cases of the suite `calibration`.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "host/calibration_bound.h"
#include "host/calibration_suite.h"
#include "host/calibration_tally.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kCalibrationsWanted = 30;  // fewer scatter by more than the bars leave
// The pose alone: its six errors hang together, so that of 30 draws of an exactly efficient estimator 5 %
// have an rms beyond 1.2 x the bound; of 200 fewer than 1 in 10 000 (20 000 trials with the stated
// covariance).
constexpr std::size_t kPosesWanted = 200;

/// The calibration of a draw; a refusal is a finding.
std::optional<Calibration> Calibrated(const CalibrationInput& input, SuiteReport& report) {
  auto calibration = Calibrate(input);
  if (calibration) return std::move(*calibration);
  report.findings.push_back(calibration.error().Line());
  return std::nullopt;
}

std::string Px(double noise_px) { return noise_px < 0.02 ? "0.01 px" : "0.05 px"; }

/// Points ahead of the rig that both cameras see: the middle, and four around it.
std::vector<Vector3d> PointsAt(const CalibrationPlan& plan, double distance_m) {
  const double toe_rad = std::atan(plan.base_m / 2 / plan.converge_m);
  const Vector3d ahead(std::sin(toe_rad), 0, std::cos(toe_rad)),
      across(std::cos(toe_rad), 0, -std::sin(toe_rad));
  const Vector3d middle = 0.5 * plan.base_m * across + distance_m * ahead;
  std::vector<Vector3d> points{middle};
  constexpr double kAside = 0.05;  // of the distance: a quarter of the image
  for (const double side : {-kAside, kAside}) {
    points.push_back(middle + side * distance_m * across);
    points.push_back(middle + side * distance_m * Vector3d::UnitY());
  }
  return points;
}

/// Squared position errors of noise-free points and what the bound leaves, mean over the points.
struct PositionErrors {
  double error_m2 = 0, bound_m2 = 0, count = 0;

  void Add(const CalibrationPlan& plan, const CalibrationDraw& draw, const optics::Rig& rig,
           const optics::RigCovariance& bound, double distance_m) {
    for (const Vector3d& point : PointsAt(plan, distance_m)) {
      const Eigen::Vector4d raw = draw.rig.Project(point);
      const RawPair pair{raw.head<2>(), raw.tail<2>()};
      const auto place = Locate(rig, pair);
      const auto derivatives = DerivativesOf(draw.rig.AsRig(), pair);
      if (!place || !derivatives) continue;
      error_m2 += (*place - point).squaredNorm();
      bound_m2 += (derivatives->by_rig * bound * derivatives->by_rig.transpose()).trace();
      ++count;
    }
  }
  double RmsMm() const { return 1e3 * std::sqrt(error_m2 / count); }
  double BoundMm() const { return 1e3 * std::sqrt(bound_m2 / count); }
};

/// Length errors of bars with noise at one distance, of one calibration after the other.
struct LengthErrors {
  double mean_abs_m = 0, worst_m = 0, spread_m2 = 0, bound_m2 = 0, rms_m2 = 0, count = 0;

  void Add(const CalibrationPlan& plan, const CalibrationDraw& draw, const optics::Rig& rig,
           double distance_m, sim::Random& random) {
    constexpr int kBars = 400;
    double sum = 0, squares = 0, bounds = 0;
    for (int i = 0; i < kBars; ++i) {
      const TrueBar bar = WaveBar(plan, draw.rig, Eigen::Vector2d::Constant(distance_m), random);
      const auto end = [&](double place_m) {
        Eigen::Vector4d raw = draw.rig.Project(bar.led1_m + place_m * bar.direction);
        for (double& value : raw) value += plan.noise_px * Gauss(random);
        return Locate(rig, {raw.head<2>(), raw.tail<2>()}).value_or(Vector3d::Zero());
      };
      const double error = (end(plan.leds_m.back()) - end(plan.leds_m.front())).norm() - plan.leds_m.back();
      const double bound = LengthBound(plan, draw.rig, bar);
      sum += error, squares += error * error, bounds += bound * bound;
    }
    const double mean = sum / kBars;
    mean_abs_m += std::abs(mean);
    worst_m = std::max(worst_m, std::abs(mean));
    spread_m2 += squares / kBars - mean * mean;
    rms_m2 += squares / kBars;
    bound_m2 += bounds / kBars;
    ++count;
  }
};

std::string How(std::size_t count, const CalibrationPlan& plan) {
  return std::to_string(count) + " calibrations of " + std::to_string(plan.bars) +
         " simulated bars each, every tenth held out";
}

void ReportCount(std::size_t done, std::size_t wanted, SuiteReport& report) {
  report.AtLeast("calibrations not refused", static_cast<double>(done), static_cast<double>(wanted), "", 0);
}

}  // namespace

SuiteReport MeasurePose(const CaseOrder& order) {
  const std::size_t count = order.CountOr(kPosesWanted);
  SuiteReport report;
  std::size_t done = 0;
  CalibrationPlan plan;
  plan.intrinsics = {0, 0, 0};
  plan.bar_sigma_m = 0;
  report.how = How(count, plan);
  for (const double noise_px : {0.01, 0.05}) {
    plan.noise_px = noise_px;
    ErrorTally tally;
    for (std::size_t i = 0; i < count; ++i) {
      const CalibrationDraw draw = Draw(plan, PieceSeed(order, i));
      const auto calibration = Calibrated(draw.input, report);
      const auto bound = CalibrationBound(plan, draw);
      if (!calibration || !bound) continue;
      tally.Add(ErrorOf(draw.rig, calibration->rig), calibration->covariance, *bound,
                FreeDirections(draw.input));
      ++done;
    }
    tally.Report(Px(noise_px) + ", pose", 0, 6, report);
    tally.ReportHonesty(Px(noise_px), report);
  }
  ReportCount(done, 2 * count, report);
  return report;
}

SuiteReport MeasureRefined(const CaseOrder& order) {
  const std::size_t count = order.CountOr(kCalibrationsWanted);
  SuiteReport report;
  std::size_t done = 0;
  CalibrationPlan plan;
  report.how = How(count, plan) + "; intrinsics wrong by 0.05 % f, 1 px centre, 0.2 px distortion (1 sigma)";
  for (const double noise_px : {0.01, 0.05}) {
    plan.noise_px = noise_px;
    ErrorTally tally;
    PositionErrors refined, alone;
    for (std::size_t i = 0; i < count; ++i) {
      const CalibrationDraw draw = Draw(plan, PieceSeed(order, i));
      const auto calibration = Calibrated(draw.input, report);
      CalibrationInput extrinsics = draw.input;
      extrinsics.left_prior = extrinsics.right_prior = {};
      const auto kept = Calibrated(extrinsics, report);
      const auto bound = CalibrationBound(plan, draw);
      if (!calibration || !kept || !bound) continue;
      tally.Add(ErrorOf(draw.rig, calibration->rig), calibration->covariance, *bound,
                FreeDirections(draw.input));
      refined.Add(plan, draw, calibration->rig, *bound, 100);
      alone.Add(plan, draw, kept->rig, *bound, 100);
      ++done;
    }
    tally.Report(Px(noise_px) + ", pose", 0, 6, report);
    tally.Report(Px(noise_px) + ", intrinsics", 6, 8, report);
    tally.ReportHonesty(Px(noise_px), report);
    report.Inform(Px(noise_px) + ", error at 100 m, extrinsics only", alone.RmsMm(), "mm", 1);
    report.Inform(Px(noise_px) + ", error at 100 m, refined", refined.RmsMm(), "mm", 1);
    report.AtLeast(Px(noise_px) + ", refined is better by", alone.RmsMm() / refined.RmsMm(), 4);
  }
  ReportCount(done, 2 * count, report);
  return report;
}

SuiteReport MeasureTable52(const CaseOrder& order) {
  constexpr std::array kDistancesM{30.0, 50.0, 70.0}, kBarsMm{0.4, 0.5, 0.6};
  const std::size_t count = order.CountOr(kCalibrationsWanted);
  SuiteReport report;
  std::size_t done = 0;
  CalibrationPlan plan;
  report.how = How(count, plan) + "; then 400 bars a distance, LEDs measured one by one";
  for (const double base_m : {6.0, 12.0}) {
    plan.base_m = base_m;
    plan.converge_m = 30;
    std::array<LengthErrors, kDistancesM.size()> errors;
    for (std::size_t i = 0; i < count; ++i) {
      const CalibrationDraw draw = Draw(plan, PieceSeed(order, i));
      const auto calibration = Calibrated(draw.input, report);
      if (!calibration) continue;
      sim::Random random(PieceSeed(order, i), 1);
      for (std::size_t k = 0; k < errors.size(); ++k)
        errors[k].Add(plan, draw, calibration->rig, kDistancesM[k], random);
      ++done;
    }
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const std::string where = "base " + std::to_string(std::lround(base_m)) + ", " +
                                std::to_string(std::lround(kDistancesM[k])) + " m";
      const LengthErrors& e = errors[k];
      report.AtMost(where + ": mean bar error", 1e3 * e.mean_abs_m / e.count, kBarsMm[k], "mm");
      report.Inform(where + ": of the worst calibration", 1e3 * e.worst_m, "mm");
      report.Inform(where + ": spread", 1e3 * std::sqrt(e.spread_m2 / e.count), "mm");
      report.AtMost(where + ": spread / bound", std::sqrt(e.spread_m2 / e.bound_m2), 1.25);
    }
  }
  ReportCount(done, 2 * count, report);
  return report;
}

SuiteReport MeasureTable54(const CaseOrder& order) {
  constexpr std::array kDistancesM{20.0, 30.0, 50.0, 80.0, 100.0};
  const std::size_t count = order.CountOr(kCalibrationsWanted);
  SuiteReport report;
  std::size_t done = 0;
  CalibrationPlan plan;
  plan.leds_m = {0, 0.25, 0.65, 1.5};
  plan.nearest_m = 20, plan.farthest_m = 40, plan.far_share = 0.4;
  report.how = How(count, plan) + ", 60 % at 20 to 40 m and the others to 100 m";
  std::array<PositionErrors, kDistancesM.size()> positions;
  std::array<LengthErrors, kDistancesM.size()> lengths;
  for (std::size_t i = 0; i < count; ++i) {
    const CalibrationDraw draw = Draw(plan, PieceSeed(order, i));
    const auto calibration = Calibrated(draw.input, report);
    const auto bound = CalibrationBound(plan, draw);
    if (!calibration || !bound) continue;
    sim::Random random(PieceSeed(order, i), 1);
    for (std::size_t k = 0; k < kDistancesM.size(); ++k) {
      positions[k].Add(plan, draw, calibration->rig, *bound, kDistancesM[k]);
      lengths[k].Add(plan, draw, calibration->rig, kDistancesM[k], random);
    }
    ++done;
  }
  for (std::size_t k = 0; k < kDistancesM.size(); ++k) {
    const std::string where = std::to_string(std::lround(kDistancesM[k])) + " m";
    report.Inform(where + ": position error, rms over calibrations", positions[k].RmsMm(), "mm");
    report.AtMost(where + ": the same / bound", positions[k].RmsMm() / positions[k].BoundMm(), 1.5);
    const LengthErrors& e = lengths[k];
    report.AtMost(where + ": half bar-length error, rms of single bars",
                  0.5e3 * std::sqrt(e.rms_m2 / e.count), 2, "mm");
  }
  ReportCount(done, count, report);
  return report;
}

}  // namespace adit::host
