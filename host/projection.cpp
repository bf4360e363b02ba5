#include "host/projection.h"

namespace adit::host {

std::optional<Projection> ProjectWithDerivatives(const optics::CameraModel& camera,
                                                 const Eigen::Vector3d& point_m) {
  if (!(point_m.z() > 0)) return std::nullopt;
  const Eigen::Vector2d ideal = point_m.head<2>() / point_m.z();
  Eigen::Matrix2d by_ideal;
  const Eigen::Vector2d distorted = camera.Distort(ideal, &by_ideal);
  const double x = ideal.x(), y = ideal.y(), r2 = ideal.squaredNorm();
  const Eigen::Vector2d focal_px(camera.fu_px, camera.fv_px);
  Eigen::Matrix<double, 2, 3> ideal_by_point;
  ideal_by_point << 1 / point_m.z(), 0, -x / point_m.z(), 0, 1 / point_m.z(), -y / point_m.z();
  Projection out;
  out.raw_px = camera.Pixel(distorted);
  out.by_point = focal_px.asDiagonal() * by_ideal * ideal_by_point;
  Eigen::Matrix<double, 2, 4> distortion;
  distortion << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, y * r2, y * r2 * r2, r2 + 2 * y * y,
      2 * x * y;
  out.by_camera.row(0) << distorted.x(), 0, 1, 0, camera.fu_px * distortion.row(0);
  out.by_camera.row(1) << 0, distorted.y(), 0, 1, camera.fv_px * distortion.row(1);
  return out;
}

}  // namespace adit::host
