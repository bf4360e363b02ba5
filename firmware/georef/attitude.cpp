#include "firmware/georef/attitude.h"

#include <cmath>
#include <numbers>

namespace adit::georef {

std::optional<Attitude> AttitudeOf(const Eigen::Matrix3d& R_s_t) {
  constexpr double kLevelMin = 0.01745;  // sine of 1 degree
  const double level = std::hypot(R_s_t(0, 0), R_s_t(1, 0));
  if (!(level > kLevelMin)) return std::nullopt;  // a NaN is no attitude
  Attitude attitude;
  attitude.heading_rad = std::atan2(R_s_t(0, 0), R_s_t(1, 0));
  if (attitude.heading_rad < 0) attitude.heading_rad += 2 * std::numbers::pi;
  attitude.pitch_rad = std::atan2(R_s_t(2, 0), level);
  attitude.roll_rad = std::atan2(R_s_t(2, 1), R_s_t(2, 2));
  return attitude;
}

}  // namespace adit::georef
