#include "host/calibration_tables.h"

#include <cmath>
#include <string>

#include "host/intrinsic_parameters.h"

namespace adit::host {
namespace {

ReportCell Count(std::size_t n) { return ReportNumber(static_cast<double>(n), 0); }

/// A camera before and after.
struct Lens {
  const char* name;
  const IntrinsicPrior& prior;
  IntrinsicVector file, refined, sigma;
};

/// The parameters that the file leaves free.
void AddIntrinsics(const Lens& lens, ReportTable& table) {
  for (Eigen::Index i = 0; i < kIntrinsics; ++i) {
    const double file_sigma = lens.prior.root.row(i).norm();
    if (!(file_sigma > 0)) continue;
    constexpr Eigen::Index kInPixels = 4;
    const int decimals = i < kInPixels ? 2 : 5;
    table.rows.push_back({ReportWords(lens.name), ReportWords(kIntrinsicNames[static_cast<std::size_t>(i)]),
                          ReportNumber(lens.refined[i], decimals), ReportNumber(lens.sigma[i], decimals),
                          ReportNumber(lens.file[i], decimals), ReportNumber(file_sigma, decimals),
                          ReportNumber((lens.refined[i] - lens.file[i]) / file_sigma, 2)});
  }
}

}  // namespace

std::vector<ReportFact> QualityFacts(const Calibration& calibration) {
  const CalibrationQuality& q = calibration.quality;
  const Eigen::Vector3d sigma_urad = 1e6 * q.sigma_rad;
  return {{"bars_seen", "bars seen", Count(q.bars_seen), ""},
          {"bars_used", "of them adjusted", Count(q.bars_used), ""},
          {"bars_held_out", "held out", Count(q.hold_out.bars.size()), ""},
          {"wrong_pairs", "wrong pairs", Count(calibration.wrong.size()), ""},
          {"points_used", "lights at rest", Count(q.points_used), ""},
          {"nearest_m", "nearest bar", ReportNumber(q.nearest_m, 1), "m"},
          {"farthest_m", "farthest bar", ReportNumber(q.farthest_m, 1), "m"},
          {"baseline_m", "baseline", ReportNumber(q.baseline_m, 4), "m"},
          {"baseline_sigma_mm", "baseline sigma", ReportNumber(1e3 * q.baseline_sigma_m, 2), "mm"},
          {"pitch_sigma_urad", "pitch sigma", ReportNumber(sigma_urad.x(), 1), "\u00b5rad"},
          {"yaw_sigma_urad", "yaw sigma", ReportNumber(sigma_urad.y(), 1), "\u00b5rad"},
          {"roll_sigma_urad", "roll sigma", ReportNumber(sigma_urad.z(), 1), "\u00b5rad"},
          {"rms_px", "residual, rms", ReportNumber(q.rms_px, 4), "px"},
          {"sigma0", "residual / promised", ReportNumber(q.sigma0, 2), ""},
          {"bar_bias_mm", "bar error, mean", ReportNumber(1e3 * q.bar_bias_m, 2), "mm"},
          {"bar_rms_mm", "bar error, rms", ReportNumber(1e3 * q.bar_rms_m, 2), "mm"},
          {"coverage_left_pct", "coverage of cam0", ReportNumber(q.coverage_left_pct, 0), "%"},
          {"coverage_right_pct", "coverage of cam1", ReportNumber(q.coverage_right_pct, 0), "%"},
          {"intrinsics_pull", "lenses moved by, rms", ReportNumber(q.intrinsics_pull, 2), "\u03c3"},
          {"hold_out_error_mm", "held-out bars, rms", ReportNumber(1e3 * q.hold_out.error_m, 2), "mm"},
          {"hold_out_predicted_mm", "predicted", ReportNumber(1e3 * q.hold_out.predicted_m, 2), "mm"},
          {"hold_out_ratio", "error / predicted", ReportNumber(q.hold_out.ratio, 2), ""},
          {"wave_next", "wave next, in cam0",
           ReportWords(q.gaps.empty() ? "nowhere" : q.gaps.front().Words()), ""}};
}

ReportTable IntrinsicTable(const CalibrationInput& input, const Calibration& calibration) {
  ReportTable table{"intrinsics",
                    "The lenses as refined, beside their camera files (1 sigma). px; k and p have no unit.",
                    {{"camera", "camera"},
                     {"parameter", "parameter"},
                     {"value", "refined"},
                     {"sigma", "sigma"},
                     {"file", "in the file"},
                     {"file_sigma", "its sigma"},
                     {"shift_sigma", "shift, sigmas"}},
                    {}};
  const auto sigmas = calibration.covariance.diagonal().cwiseMax(0).cwiseSqrt().eval();
  AddIntrinsics({"cam0", input.left_prior, Intrinsics(input.left), Intrinsics(calibration.rig.left),
                 sigmas.segment<kIntrinsics>(6)},
                table);
  AddIntrinsics({"cam1", input.right_prior, Intrinsics(input.right), Intrinsics(calibration.rig.right),
                 sigmas.tail<kIntrinsics>()},
                table);
  return table;
}

ReportTable PredictionTable(const CalibrationQuality& quality) {
  ReportTable table{"predictions",
                    "A point straight ahead: what the calibration leaves (1 sigma, mm), one LED's noise in "
                    "depth, and what moves the depth: relative yaw, and disparity.",
                    {{"distance_m", "distance, m"},
                     {"across_mm", "across, mm"},
                     {"up_mm", "up, mm"},
                     {"depth_mm", "depth, mm"},
                     {"noise_mm", "noise, mm"},
                     {"depth_mm_per_urad_yaw", "mm per \u00b5rad of yaw"},
                     {"depth_mm_per_0_01_px", "mm per 0.01 px"}},
                    {}};
  for (const RigPrediction& p : quality.predictions) {
    table.rows.push_back(
        {ReportNumber(p.distance_m, 0), ReportNumber(1e3 * p.across_m, 1), ReportNumber(1e3 * p.up_m, 1),
         ReportNumber(1e3 * p.depth_m, 1), ReportNumber(1e3 * p.noise_depth_m, 1),
         ReportNumber(1e-3 * p.depth_per_yaw_m_rad, 2), ReportNumber(10 * p.depth_per_px_m, 2)});
  }
  return table;
}

ReportTable GapTable(const std::vector<CoverageGap>& gaps) {
  ReportTable table{"wave_next",
                    "Where both cameras look and no bar was, the most telling place first: depth (1 sigma) "
                    "that the calibration leaves there, and one LED's noise.",
                    {{"region", "region of cam0"}, {"depth_mm", "depth, mm"}, {"noise_mm", "noise, mm"}},
                    {}};
  for (const CoverageGap& gap : gaps) {
    table.rows.push_back({ReportWords(gap.Words()), ReportNumber(1e3 * gap.depth_m, 1),
                          ReportNumber(1e3 * gap.noise_depth_m, 1)});
  }
  return table;
}

ReportTable WrongPairTable(const CalibrationInput& input, const std::vector<WrongPair>& wrong) {
  ReportTable table{
      "wrong_pairs",
      "Wrong pairs, left out.",
      {{"recording", "recording"}, {"time_ns", "time, ns"}, {"target", "target"}, {"reason", "reason"}},
      {}};
  for (const WrongPair& pair : wrong) {
    table.rows.push_back({ReportWords(input.recordings[pair.recording]),
                          ReportWords(std::to_string(pair.mid_exposure_ns)),
                          ReportWords(input.targets[pair.target].name), ReportWords(pair.reason)});
  }
  return table;
}

}  // namespace adit::host
