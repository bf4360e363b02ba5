#include "host/calibration_text.h"

#include <iomanip>
#include <sstream>

#include "host/provenance.h"

namespace adit::host {
namespace {

void WriteCovariance(const Eigen::Matrix<double, 6, 6>& covariance, std::ostream& text) {
  text << "covariance:  # of (rotation vector in cam1's frame: rad, translation: m)\n"
       << std::setprecision(9);
  for (Eigen::Index r = 0; r < covariance.rows(); ++r) {
    text << "  - [";
    for (Eigen::Index c = 0; c < covariance.cols(); ++c) text << (c == 0 ? "" : ", ") << covariance(r, c);
    text << "]\n";
  }
}

}  // namespace

std::string FormatCalibration(const Calibration& calibration) {
  optics::Rig rig = calibration.rig;
  rig.calibration_id.clear();
  rig.calibration_id = Crc32(optics::FormatRig(rig));

  const CalibrationQuality& q = calibration.quality;
  std::ostringstream text;
  text << optics::FormatRig(rig) << "time: \"" << Utc(calibration.newest_bar_ns) << "\"\n";
  WriteCovariance(calibration.covariance, text);
  text << std::setprecision(6) << "quality:\n  bars_seen: " << q.bars_seen << "\n  bars_used: " << q.bars_used
       << "\n  rms_px: " << q.rms_px << "\n  sigma0: " << q.sigma0 << "\n  baseline_m: " << q.baseline_m
       << "\n  baseline_sigma_m: " << q.baseline_sigma_m << "\n  pitch_yaw_roll_sigma_rad: ["
       << q.sigma_rad.x() << ", " << q.sigma_rad.y() << ", " << q.sigma_rad.z()
       << "]\n  bar_bias_m: " << q.bar_bias_m << "\n  bar_rms_m: " << q.bar_rms_m << "\n  distance_m: ["
       << q.nearest_m << ", " << q.farthest_m << "]\n  coverage_pct: [" << q.coverage_left_pct << ", "
       << q.coverage_right_pct << "]  # of 8 x 6 cells of cam0, cam1\n";
  return text.str();
}

std::string Summary(const CalibrationQuality& q) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "bars      " << q.bars_used << " of " << q.bars_seen
       << " used, " << q.nearest_m << " to " << q.farthest_m << " m away\n"
       << std::setprecision(3) << "residual  " << q.rms_px << " px rms, " << q.sigma0
       << " of what the centroids promise\n"
       << std::setprecision(4) << "baseline  " << q.baseline_m << " m, sigma " << std::setprecision(2)
       << q.baseline_sigma_m * 1e3 << " mm\n"
       << std::setprecision(1) << "pose      sigma pitch " << q.sigma_rad.x() * 1e6 << ", yaw "
       << q.sigma_rad.y() * 1e6 << ", roll " << q.sigma_rad.z() * 1e6 << " urad\n"
       << std::setprecision(2) << "bar       mean error " << q.bar_bias_m * 1e3 << " mm, rms "
       << q.bar_rms_m * 1e3 << " mm\n"
       << std::setprecision(0) << "coverage  " << q.coverage_left_pct << " % of cam0, "
       << q.coverage_right_pct << " % of cam1\n";
  return text.str();
}

}  // namespace adit::host
