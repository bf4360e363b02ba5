#include "drivers/sim/projection.h"

namespace adit::sim {
namespace {

/// Whether r -> r (1 + k1 r^2 + k2 r^4) rises from 0 all the way to r^2 = `s_end`.
bool RisesUpTo(double s_end, const optics::CameraModel& camera) {
  const auto slope = [&camera](double s) { return 1 + 3 * camera.k1 * s + 5 * camera.k2 * s * s; };
  if (slope(s_end) <= 0) return false;
  if (camera.k2 <= 0) return true;  // then the slope has no minimum inside
  const double s_lowest = -0.3 * camera.k1 / camera.k2;
  return s_lowest <= 0 || s_lowest >= s_end || slope(s_lowest) > 0;
}

}  // namespace

std::optional<Eigen::Vector2d> ProjectPoint(const optics::CameraModel& camera,
                                            const Eigen::Vector3d& point_m) {
  constexpr double kNearestM = 0.01;
  if (point_m.z() < kNearestM) return std::nullopt;
  const double x = point_m.x() / point_m.z();
  const double y = point_m.y() / point_m.z();
  const double xx = x * x, yy = y * y, xy = x * y;
  const double s = xx + yy;
  if (!RisesUpTo(s, camera)) return std::nullopt;
  const double stretch = 1 + camera.k1 * s + camera.k2 * s * s;
  const double x_d = stretch * x + 2 * camera.p1 * xy + camera.p2 * (3 * xx + yy);
  const double y_d = stretch * y + camera.p1 * (xx + 3 * yy) + 2 * camera.p2 * xy;
  return Eigen::Vector2d(camera.cu_px + camera.fu_px * x_d, camera.cv_px + camera.fv_px * y_d);
}

}  // namespace adit::sim
