#include "host/rig_uncertainty.h"

#include <Eigen/Geometry>
#include <cmath>

#include "host/essential.h"
#include "host/intrinsic_parameters.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;
using Parameters = Eigen::Matrix<double, optics::kRigParameters, 1>;

/// Steps that move a pixel by about 1e-3: far above rounding, far below curvature.
Parameters Steps(const optics::Rig& rig) {
  const double f = rig.left.fu_px;
  Parameters steps;
  const double radian = 1e-3 / f, metre = 1e-5 * rig.BaselineM();
  IntrinsicVector camera;
  camera << 1e-3, 1e-3, 1e-3, 1e-3, 1e-5, 1e-4, 1e-6, 1e-6;
  steps << radian, radian, radian, metre, metre, metre, camera, camera;
  return steps;
}

/// A point `distance_m` ahead of the middle of the baseline, between both axes of view.
Vector3d Ahead(const optics::Rig& rig, double distance_m) {
  const Vector3d centre = 0.5 * rig.T_r_l.Inverse().translation_m;
  const Vector3d axis = (Vector3d::UnitZ() + rig.T_r_l.rotation.transpose() * Vector3d::UnitZ()).normalized();
  return centre + distance_m * axis;
}

/// Across (level), up and along, as rows.
Eigen::Matrix3d ViewAxes(const Vector3d& ahead, const Vector3d& from) {
  const Vector3d along = (ahead - from).normalized();
  const Vector3d across = Vector3d::UnitY().cross(along).normalized();
  Eigen::Matrix3d axes;
  axes << across.transpose(), along.cross(across).transpose(), along.transpose();
  return axes;
}

}  // namespace

optics::Rig Moved(const optics::Rig& rig, const Parameters& step) {
  optics::Rig moved = rig;
  const Vector3d turn = step.head<3>();
  if (turn.norm() > 0)
    moved.T_r_l.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * rig.T_r_l.rotation;
  moved.T_r_l.translation_m += step.segment<3>(3);
  moved.left = CameraOf(Intrinsics(rig.left) + step.segment<kIntrinsics>(6), rig.left);
  moved.right = CameraOf(Intrinsics(rig.right) + step.tail<kIntrinsics>(), rig.right);
  return moved;
}

std::optional<Vector3d> Locate(const optics::Rig& rig, const RawPair& pair) {
  const auto left = rig.left.Undistort(pair.left_px), right = rig.right.Undistort(pair.right_px);
  if (!left || !right) return std::nullopt;
  const auto place = Triangulate(rig.T_r_l, {rig.left.Normalised(*left), rig.right.Normalised(*right)});
  if (!place || !(place->depth_left > 0) || !(place->depth_right > 0)) return std::nullopt;
  return place->point_l;
}

std::optional<PlaceDerivatives> DerivativesOf(const optics::Rig& rig, const RawPair& pair) {
  PlaceDerivatives out;
  const Parameters steps = Steps(rig);
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const Parameters step = steps[i] * Parameters::Unit(i);
    const auto more = Locate(Moved(rig, step), pair), less = Locate(Moved(rig, -step), pair);
    if (!more || !less) return std::nullopt;
    out.by_rig.col(i) = (*more - *less) / (2 * steps[i]);
  }
  constexpr double kStepPx = 1e-3;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Eigen::Vector4d step = kStepPx * Eigen::Vector4d::Unit(i);
    const auto more = Locate(rig, {pair.left_px + step.head<2>(), pair.right_px + step.tail<2>()});
    const auto less = Locate(rig, {pair.left_px - step.head<2>(), pair.right_px - step.tail<2>()});
    if (!more || !less) return std::nullopt;
    out.by_pixel.col(i) = (*more - *less) / (2 * kStepPx);
  }
  return out;
}

std::optional<RigPrediction> PredictAt(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                       const Vector3d& point, double noise_px) {
  const auto left_px = rig.left.Project(point), right_px = rig.right.Project(rig.T_r_l * point);
  if (!left_px || !right_px) return std::nullopt;
  const auto derivatives = DerivativesOf(rig, {*left_px, *right_px});
  if (!derivatives) return std::nullopt;
  const Vector3d middle = 0.5 * rig.T_r_l.Inverse().translation_m;
  const Eigen::Matrix3d axes = ViewAxes(point, middle);
  const Eigen::Matrix<double, 3, optics::kRigParameters> by_rig = axes * derivatives->by_rig;
  const Eigen::Matrix<double, 3, 4> by_pixel = axes * derivatives->by_pixel;
  const Vector3d sigma_m = (by_rig * covariance * by_rig.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  RigPrediction out;
  out.distance_m = (point - middle).norm();
  out.across_m = sigma_m.x(), out.up_m = sigma_m.y(), out.depth_m = sigma_m.z();
  out.noise_depth_m = noise_px * by_pixel.row(2).norm();
  out.depth_per_yaw_m_rad = std::abs(by_rig(2, 1));
  out.depth_per_px_m = 0.5 * std::abs(by_pixel(2, 2) - by_pixel(2, 0));
  return out;
}

std::optional<RigPrediction> Predict(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                     double distance_m, double noise_px) {
  return PredictAt(rig, covariance, Ahead(rig, distance_m), noise_px);
}

}  // namespace adit::host
