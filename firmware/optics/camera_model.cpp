#include "firmware/optics/camera_model.h"

#include <Eigen/LU>

namespace adit::optics {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Vector2d CameraModel::Distort(const Vector2d& ideal, Matrix2d* jacobian) const {
  const double x = ideal.x(), y = ideal.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * k2);
  if (jacobian != nullptr) {
    const double slope = 2 * (k1 + 2 * k2 * r2);  // d radial / d r2, times 2
    (*jacobian)(0, 0) = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
    (*jacobian)(0, 1) = x * y * slope + 2 * p1 * x + 2 * p2 * y;
    (*jacobian)(1, 0) = (*jacobian)(0, 1);
    (*jacobian)(1, 1) = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

std::optional<Vector2d> CameraModel::Project(const Eigen::Vector3d& point_m) const {
  constexpr double kNearestM = 1e-6;  // closer than any optics: behind or inside the projection centre
  if (!(point_m.z() > kNearestM)) return std::nullopt;
  return Pixel(Distort(point_m.head<2>() / point_m.z()));
}

std::optional<Vector2d> CameraModel::Undistort(const Vector2d& raw_px, Matrix2d* jacobian) const {
  const Vector2d distorted = Normalised(raw_px);
  Vector2d ideal = distorted;
  Matrix2d slope;
  constexpr int kSteps = 10;
  constexpr double kConverged = 1e-13;  // normalised: 3e-10 px at f = 3400 px
  for (int step = 0; step < kSteps; ++step) {
    const Vector2d miss = Distort(ideal, &slope) - distorted;
    const double det = slope.determinant();
    if (!(det > 0.05))
      return std::nullopt;  // a lens squeezes area by a few percent, not twentyfold: folded over
    const Vector2d move(slope(1, 1) * miss.x() - slope(0, 1) * miss.y(),
                        slope(0, 0) * miss.y() - slope(1, 0) * miss.x());
    ideal -= move / det;
    if (miss.cwiseAbs().maxCoeff() < kConverged) {
      if (jacobian != nullptr) {
        Distort(ideal, &slope);
        // d ideal_px / d raw_px = F (d distorted / d ideal)^-1 F^-1 with F = diag(fu, fv)
        *jacobian = slope.inverse();
        (*jacobian)(0, 1) *= fu_px / fv_px;
        (*jacobian)(1, 0) *= fv_px / fu_px;
      }
      return Pixel(ideal);
    }
  }
  return std::nullopt;
}

Eigen::Matrix3d CameraModel::K() const {
  Eigen::Matrix3d k;
  k << fu_px, 0, cu_px, 0, fv_px, cv_px, 0, 0, 1;
  return k;
}

}  // namespace adit::optics
