#include "firmware/stereo/view.h"

#include <cmath>

namespace adit::stereo {

bool View::Project(const Eigen::Vector3d& point_b_m, Eigen::Vector2d& px,
                   Eigen::Matrix<double, 2, 3>& slope) const {
  constexpr double kNearestM = 1e-3;  // in front of any lens
  const Eigen::Vector3d p = rotation * point_b_m + translation_m;
  if (!(p.z() > kNearestM)) return false;
  const double inverse = 1 / p.z();
  px = {fu_px * p.x() * inverse + cu_px, fv_px * p.y() * inverse + cv_px};
  slope.row(0) = fu_px * inverse * (rotation.row(0) - p.x() * inverse * rotation.row(2));
  slope.row(1) = fv_px * inverse * (rotation.row(1) - p.y() * inverse * rotation.row(2));
  return true;
}

Eigen::Vector3d View::Ray(const Eigen::Vector2d& ideal_px) const {
  const Eigen::Vector2d n = Normalised(ideal_px);
  return rotation.transpose() * Eigen::Vector3d(n.x(), n.y(), 1);
}

Views MakeViews(const optics::Rig& rig) {
  const auto view = [](const optics::CameraModel& camera) {
    View v;
    v.fu_px = camera.fu_px, v.fv_px = camera.fv_px, v.cu_px = camera.cu_px, v.cv_px = camera.cv_px;
    return v;
  };
  Views views{view(rig.left), view(rig.right)};
  views[1].rotation = rig.T_r_l.rotation;
  views[1].translation_m = rig.T_r_l.translation_m;
  return views;
}

Eigen::Matrix2d Observation::Whitener(double floor_px) const {
  if (!seen) return Eigen::Matrix2d::Zero();
  const double add = floor_px * floor_px + kNoiseMinPx * kNoiseMinPx;
  // Inverse of the lower Cholesky factor, written out; the diagonal is positive by `add` for any covariance
  // that is not negative.
  const double l00 = std::sqrt(covariance_px2(0, 0) + add);
  const double l10 = covariance_px2(1, 0) / l00;
  const double l11 = std::sqrt(covariance_px2(1, 1) + add - l10 * l10);
  Eigen::Matrix2d w;
  w << 1 / l00, 0, -l10 / (l00 * l11), 1 / l11;
  return w;
}

}  // namespace adit::stereo
