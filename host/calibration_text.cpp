#include "host/calibration_text.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"
#include "host/provenance.h"

namespace adit::host {
namespace {

constexpr std::size_t kWrongShown = 12, kGapsShown = 3;

void WriteQuality(const Calibration& calibration, std::ostream& text) {
  const CalibrationQuality& q = calibration.quality;
  text << std::setprecision(6) << "quality:\n  bars_seen: " << q.bars_seen << "\n  bars_used: " << q.bars_used
       << "\n  points_used: " << q.points_used << "\n  wrong_pairs: " << calibration.wrong.size()
       << "\n  rms_px: " << q.rms_px << "\n  sigma0: " << q.sigma0 << "\n  baseline_m: " << q.baseline_m
       << "\n  baseline_sigma_m: " << q.baseline_sigma_m << "\n  pitch_yaw_roll_sigma_rad: ["
       << q.sigma_rad.x() << ", " << q.sigma_rad.y() << ", " << q.sigma_rad.z()
       << "]\n  bar_bias_m: " << q.bar_bias_m << "\n  bar_rms_m: " << q.bar_rms_m << "\n  distance_m: ["
       << q.nearest_m << ", " << q.farthest_m << "]\n  coverage_pct: [" << q.coverage_left_pct << ", "
       << q.coverage_right_pct << "]  # of 8 x 6 cells of cam0, cam1\n  wave_next: "
       << base::Quoted(q.gaps.empty() ? "" : q.gaps.front().Words())
       << "\n  intrinsics_pull: " << q.intrinsics_pull << "\n  hold_out: {bars: " << q.hold_out.bars.size()
       << ", error_m: " << q.hold_out.error_m << ", predicted_m: " << q.hold_out.predicted_m
       << ", ratio: " << q.hold_out.ratio << "}\n  predicted_sigma_m:  # across, up, depth\n";
  for (const RigPrediction& p : q.predictions) {
    text << "    - {distance_m: " << p.distance_m << ", sigma_m: [" << p.across_m << ", " << p.up_m << ", "
         << p.depth_m << "]}\n";
  }
}

void WritePredictions(const CalibrationQuality& q, std::ostream& text) {
  text << "expect    from the calibration (1 sigma, mm) and one LED's noise; depth by yaw and by disparity\n";
  for (const RigPrediction& p : q.predictions) {
    text << std::setprecision(0) << "  " << std::setw(5) << p.distance_m << " m  " << std::setprecision(1)
         << "across " << p.across_m * 1e3 << ", up " << p.up_m * 1e3 << ", depth " << p.depth_m * 1e3
         << "; noise " << p.noise_depth_m * 1e3 << "; " << std::setprecision(2)
         << p.depth_per_yaw_m_rad * 1e-3 << " mm/urad, " << p.depth_per_px_m * 10 << " mm/0.01 px\n";
  }
}

void WriteGaps(const CalibrationQuality& q, std::ostream& text) {
  if (q.gaps.empty()) {
    text << "wave next nowhere: the bars have been wherever both cameras look, 10 to 120 m\n";
    return;
  }
  text << "wave next (in cam0; depth left by the calibration and by one LED's noise, 1 sigma, mm)\n"
       << std::setprecision(1);
  for (std::size_t i = 0; i < std::min(kGapsShown, q.gaps.size()); ++i) {
    const CoverageGap& gap = q.gaps[i];
    text << "  " << gap.Words() << ": " << gap.depth_m * 1e3 << ", " << gap.noise_depth_m * 1e3 << "\n";
  }
}

void WriteIntrinsics(const Calibration& calibration, std::ostream& text) {
  const CalibrationQuality& q = calibration.quality;
  if (q.intrinsics_pull == 0) {
    text << "cameras   as in their files\n";
    return;
  }
  text << std::setprecision(2) << "cameras   refined within their priors, by " << q.intrinsics_pull
       << " sigma rms\n";
  const auto line = [&](const char* name, const optics::CameraModel& c, Eigen::Index first) {
    const auto sigma = [&](Eigen::Index i) {
      return std::sqrt(calibration.covariance(first + i, first + i));
    };
    text << std::setprecision(2) << "  " << name << "    f " << c.fu_px << " +- " << sigma(0) << ", centre "
         << c.cu_px << " +- " << sigma(2) << ", " << c.cv_px << " +- " << sigma(3) << " px, k1 "
         << std::setprecision(5) << c.k1 << " +- " << sigma(4) << "\n";
  };
  line("cam0", calibration.rig.left, 6);
  line("cam1", calibration.rig.right, 6 + kIntrinsics);
}

}  // namespace

std::string FormatCalibration(const Calibration& calibration) {
  optics::Rig rig = calibration.rig;
  rig.calibration_id.clear();
  rig.calibration_id = Crc32(optics::FormatRig(rig));
  std::ostringstream text;
  text << optics::FormatRig(rig) << "time: \"" << Utc(calibration.newest_bar_ns)
       << "\"\nverdict: " << (calibration.verdict == Verdict::kGood ? "good" : "usable") << "\n"
       << optics::FormatRigCovariance(calibration.covariance);
  WriteQuality(calibration, text);
  return text.str();
}

std::string Summary(const Calibration& calibration) {
  const CalibrationQuality& q = calibration.quality;
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "bars      " << q.bars_used << " of " << q.bars_seen
       << " used, " << q.nearest_m << " to " << q.farthest_m << " m away";
  text << "\n"
       << std::setprecision(3) << "residual  " << q.rms_px << " px rms, " << q.sigma0
       << " of what the centroids promise\n"
       << std::setprecision(4) << "baseline  " << q.baseline_m << " m, sigma " << std::setprecision(2)
       << q.baseline_sigma_m * 1e3 << " mm\n"
       << std::setprecision(1) << "pose      sigma pitch " << q.sigma_rad.x() * 1e6 << ", yaw "
       << q.sigma_rad.y() * 1e6 << ", roll " << q.sigma_rad.z() * 1e6 << " urad\n";
  WriteIntrinsics(calibration, text);
  text << std::setprecision(2) << "bar       mean error " << q.bar_bias_m * 1e3 << " mm, rms "
       << q.bar_rms_m * 1e3 << " mm\n";
  if (!q.hold_out.bars.empty()) {
    text << "held out  " << q.hold_out.bars.size() << " bars miss their length by "
         << q.hold_out.error_m * 1e3 << " mm rms, " << q.hold_out.predicted_m * 1e3 << " mm predicted (ratio "
         << q.hold_out.ratio << ")\n";
  }
  WritePredictions(q, text);
  text << std::setprecision(0) << "coverage  " << q.coverage_left_pct << " % of cam0, "
       << q.coverage_right_pct << " % of cam1\n";
  WriteGaps(q, text);
  return text.str();
}

std::string LightsText(const Calibration& calibration, const CalibrationInput& input) {
  if (input.lights.empty()) return "";
  std::size_t left = 0, right = 0;
  for (const RestLights& lights : input.lights) left += lights.left.size(), right += lights.right.size();
  return "lights    " + std::to_string(calibration.quality.points_used) + " at rest used; " +
         std::to_string(left) + " stand still in cam0, " + std::to_string(right) + " in cam1\n";
}

std::string WrongPairs(const Calibration& calibration, const CalibrationInput& input) {
  std::ostringstream text;
  text << "wrong     " << calibration.wrong.size() << " pairs left out"
       << (calibration.wrong.size() > kWrongShown ? ", the first of them:\n" : "\n");
  for (std::size_t i = 0; i < std::min(kWrongShown, calibration.wrong.size()); ++i) {
    const WrongPair& pair = calibration.wrong[i];
    text << "  " << input.recordings[pair.recording] << " at " << pair.mid_exposure_ns << " ns, "
         << input.targets[pair.target].name << ": " << pair.reason << "\n";
  }
  return text.str();
}

std::string VerdictText(const Calibration& calibration) {
  std::string text =
      "verdict   " + std::string(calibration.verdict == Verdict::kGood ? "good" : "usable, but:") + "\n";
  for (const std::string& reservation : calibration.reservations) text += "  " + reservation + "\n";
  return text;
}

}  // namespace adit::host
