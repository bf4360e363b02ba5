// The cases of the suite `calibration` that begin with recordings.
#include <string>
#include <vector>

#include "host/calibration_bound.h"
#include "host/calibration_suite.h"
#include "host/calibration_tally.h"
#include "host/crew.h"
#include "host/filmed_calibration.h"

namespace adit::host {
namespace {

constexpr std::size_t kFilms = 30;  // as many as of simulated centroids
constexpr std::size_t kFrames = 300;

CalibrationPlan FilmPlan() {
  CalibrationPlan plan;
  plan.leds_m = {0, 0.25, 0.65, 1.5};
  plan.bars = kFrames;
  plan.noise_px = CentroidNoisePx(200);  // the bound of an LED that peaks at 200 DN
  return plan;
}

/// One calibration of a recording.
base::Result<Calibration> CalibrateFilm(const CalibrationPlan& plan, const CalibrationDraw& draw,
                                        const sim::Scene& scene, Imaging imaging) {
  CalibrationInput input = draw.input;
  input.bars = FindBars(scene, input, imaging, plan.noise_px);
  return Calibrate(input);
}

/// What became of the pieces; empty: refused, with the reason.
struct Piece {
  std::vector<Calibration> calibrations;
  std::string refusal;

  void Take(base::Result<Calibration> calibration) {
    if (calibration)
      calibrations.push_back(std::move(*calibration));
    else
      refusal = calibration.error().Line();
  }
};

void ReportRefusals(const std::vector<Piece>& pieces, std::size_t each, SuiteReport& report) {
  double done = 0;
  for (const Piece& piece : pieces) {
    done += static_cast<double>(piece.calibrations.size());
    if (!piece.refusal.empty()) report.findings.push_back(piece.refusal);
  }
  report.AtLeast("calibrations not refused", done, static_cast<double>(each * pieces.size()), "", 0);
}

double UsedPct(const Calibration& calibration) {
  const CalibrationQuality& q = calibration.quality;
  return 100.0 * static_cast<double>(q.bars_used + q.hold_out.bars.size()) / kFrames;
}

}  // namespace

SuiteReport MeasureClutter(const CaseOrder& order) {
  CalibrationPlan plan = FilmPlan();
  plan.intrinsics = {0, 0, 0};
  plan.bar_sigma_m = 0;
  const std::size_t count = order.CountOr(kFilms);
  const auto pieces = WorkInParallel<Piece>("clutter", count, [&](std::size_t i) {
    const std::uint64_t seed = PieceSeed(order, i);
    const CalibrationDraw draw = Draw(plan, seed);
    Piece piece;
    // Another seed, another noise: the two results are independent.
    piece.Take(CalibrateFilm(plan, draw, SceneOf(plan, draw, seed), ImagingOf(i)));
    sim::Scene scene = SceneOf(plan, draw, seed + 1);
    AddClutter(draw, seed, scene);
    piece.Take(CalibrateFilm(plan, draw, scene, ImagingOf(i)));
    return piece;
  });
  SuiteReport report;
  report.how = std::to_string(count) + " recordings of " + std::to_string(kFrames) +
               " frames, every tenth rendered: clean, and with 14 lamps, 3 machines' headlights and an LED "
               "hidden in 20 % of the frames";
  Honesty difference, cluttered;
  double used_pct = 0, done = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (pieces[i].calibrations.size() != 2) continue;
    const Calibration &clean = pieces[i].calibrations[0], &other = pieces[i].calibrations[1];
    const TrueRig truth = MakeTrueRig(plan.base_m, plan.converge_m);
    const RigVector error = ErrorOf(truth, other.rig);
    difference.Add((error - ErrorOf(truth, clean.rig)).head<6>(),
                   (clean.covariance + other.covariance).topLeftCorner<6, 6>());
    cluttered.Add(error.head<6>(), other.covariance.topLeftCorner<6, 6>());
    used_pct += UsedPct(other), ++done;
  }
  report.Inform("bars used or held out among clutter", used_pct / done, "%", 1);
  difference.Report("pose among clutter less the clean one", report);
  cluttered.Report("pose among clutter less truth", report);
  ReportRefusals(pieces, 2, report);
  return report;
}

SuiteReport MeasureRendered(const CaseOrder& order) {
  const CalibrationPlan plan = FilmPlan();
  const std::size_t count = order.CountOr(kFilms);
  const auto pieces = WorkInParallel<Piece>("rendered", count, [&](std::size_t i) {
    const std::uint64_t seed = PieceSeed(order, i);
    const CalibrationDraw draw = Draw(plan, seed);
    Piece piece;
    piece.Take(CalibrateFilm(plan, draw, SceneOf(plan, draw, seed), Imaging::kRendered));
    return piece;
  });
  SuiteReport report;
  report.how = std::to_string(count) + " rendered recordings of " + std::to_string(kFrames) +
               " frames, LEDs peak at 200 DN; camera files wrong by the priors, as in `intrinsics`";
  ErrorTally tally;
  double used_pct = 0, done = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (pieces[i].calibrations.empty()) continue;
    const CalibrationDraw draw = Draw(plan, PieceSeed(order, i));
    const Calibration& calibration = pieces[i].calibrations.front();
    const auto bound = CalibrationBound(plan, draw);
    if (!bound) continue;
    tally.Add(ErrorOf(draw.rig, calibration.rig), calibration.covariance, *bound, FreeDirections(draw.input));
    used_pct += UsedPct(calibration), ++done;
  }
  report.Inform("bars used or held out", used_pct / done, "%", 1);
  tally.Report("pose", 0, 6, report);
  tally.Report("intrinsics", 6, 8, report);
  tally.ReportHonesty("all", report);
  ReportRefusals(pieces, 1, report);
  return report;
}

}  // namespace adit::host
