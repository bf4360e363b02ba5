#include "firmware/optics/camera_model.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace adit::optics {
namespace {

/// The squared normalised radius up to which the model images: there d(r radial)/dr = 1 + 3 k1 s + 5 k2 s^2
/// with s = r^2 has its first zero, and rays further out fall back onto pixels that others have.
double FoldRadius2(const CameraModel& camera) {
  const double linear = 3 * camera.k1, square = 5 * camera.k2;
  const double discriminant = linear * linear - 4 * square;
  // The root in the form 2 c / (-b + ...): it holds for k2 = 0 too.
  const double divisor = discriminant < 0 ? 0 : -linear + std::sqrt(discriminant);
  return divisor > 0 ? 2 / divisor : std::numeric_limits<double>::infinity();
}

}  // namespace

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
  const Vector2d ideal = point_m.head<2>() / point_m.z();
  if (!(ideal.squaredNorm() < FoldRadius2(*this))) return std::nullopt;
  return Pixel(Distort(ideal));
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
      // A second solution beyond the fold is no ray that the lens images.
      if (!(ideal.squaredNorm() < FoldRadius2(*this))) return std::nullopt;
      if (jacobian != nullptr) {
        // The last step was too short to change the slope. d ideal_px / d raw_px = F (d distorted / d
        // ideal)^-1 F^-1 with F = diag(fu, fv)
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
