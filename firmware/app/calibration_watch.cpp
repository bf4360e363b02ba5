#include "firmware/app/calibration_watch.h"

#include <array>
#include <cstdio>

namespace adit::app {
namespace {

std::array<double, 3> InMicroradians(const std::array<double, 3>& angles_rad) {
  constexpr double kPerRad = 1e6;
  return {angles_rad[0] * kPerRad, angles_rad[1] * kPerRad, angles_rad[2] * kPerRad};
}

std::string Microradians(const std::array<double, 3>& angles_rad) {
  const std::array<double, 3> urad = InMicroradians(angles_rad);
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%.2f,%.2f,%.2f", urad[0], urad[1], urad[2]);
  return text.data();
}

const char* NameOf(watch::Verdict verdict) {
  static constexpr std::array<const char*, 3> kNames{"learning", "holds", "changed"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

}  // namespace

std::string FormatFinding(const watch::Finding& finding) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), " tracked_s=%.0f wrong=%u significance=%.1f", finding.tracked_s,
                finding.wrong, finding.significance);
  return std::string("watch verdict=") + NameOf(finding.verdict) + text.data() +
         " turn_urad=" + Microradians(finding.turn_rad) + " sigma_urad=" + Microradians(finding.sigma_rad);
}

publish::CalibrationHealth HealthOf(const watch::Finding& finding, const std::string& calibration_id) {
  return {calibration_id, NameOf(finding.verdict), finding.tracked_s, InMicroradians(finding.turn_rad),
          InMicroradians(finding.sigma_rad)};
}

std::string FormatAdvice(const watch::Finding& finding, const std::string& rig_path) {
  return rig_path + ": the calibration no longer holds, the right camera has turned by " +
         Microradians(finding.turn_rad) +
         " urad (pitch, yaw, roll); calibrate anew, or: adit rig correct --rig " + rig_path +
         " --turn-urad=" + Microradians(finding.turn_rad) +
         " --sigma-urad=" + Microradians(finding.sigma_rad) + " --out NEW.yaml";
}

}  // namespace adit::app
