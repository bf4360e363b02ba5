#include "host/bundle_costs.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "firmware/base/require.h"
#include "host/projection.h"

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Four residuals of one LED and their derivatives.
struct LedTerm {
  Eigen::Vector4d residual;
  Eigen::Matrix<double, 4, 3> by_point;
  Eigen::Matrix<double, 4, kPoseSize> by_pose;
  Eigen::Matrix<double, 4, kIntrinsics> by_left, by_right;
};

/// False behind a camera: a step too far, for which the solver takes a shorter one.
bool Evaluate(const BundleFrame& frame, const BundleCameras& cameras, const Vector3d& point_l,
              const std::array<const WhitenedView*, 2>& views, LedTerm& out) {
  const Vector3d turned = cameras.rotation * point_l;
  const auto left = ProjectWithDerivatives(cameras.left, point_l);
  const auto right = ProjectWithDerivatives(cameras.right, turned + cameras.translation_m);
  if (!left || !right) return false;
  const Eigen::Matrix2d &wl = views[0]->whiten, &wr = views[1]->whiten;
  out.residual << wl * (left->raw_px - views[0]->raw_px), wr * (right->raw_px - views[1]->raw_px);
  const Eigen::Matrix<double, 2, 3> right_by_point = wr * right->by_point;
  out.by_point << wl * left->by_point, right_by_point * cameras.rotation;
  out.by_pose.topRows<2>().setZero();
  out.by_pose.bottomLeftCorner<2, 3>() = -right_by_point * base::Skew(turned) * cameras.turn_jacobian;
  out.by_pose.bottomRightCorner<2, 3>() = right_by_point;
  out.by_left << wl * left->by_camera * frame.setting->left_prior.root,
      Eigen::Matrix<double, 2, kIntrinsics>::Zero();
  out.by_right << Eigen::Matrix<double, 2, kIntrinsics>::Zero(),
      wr * right->by_camera * frame.setting->right_prior.root;
  return true;
}

/// The rows of one LED in a block of a row-major Jacobian, if it is wanted.
template <int kRows, class Block>
void Store(double** jacobians, std::size_t which, Eigen::Index row, const Block& block) {
  if (jacobians == nullptr || jacobians[which] == nullptr) return;
  constexpr int kColumns = Block::ColsAtCompileTime;
  Eigen::Map<Eigen::Matrix<double, kRows, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(
      jacobians[which])
      .template middleRows<4>(row) = block;
}

std::array<WhitenedView, base::kLedCount> Whitened(const BarView& views, const optics::CameraModel& camera,
                                                   double noise_scale) {
  return {WhitenedView{views[0], camera, noise_scale}, WhitenedView{views[1], camera, noise_scale},
          WhitenedView{views[2], camera, noise_scale}, WhitenedView{views[3], camera, noise_scale}};
}

}  // namespace

WhitenedView::WhitenedView(const LedView& view, const optics::CameraModel& camera, double noise_scale)
    : raw_px(view.raw_px) {
  // The covariance is that of the ideal pixel; the derivative takes the raw residual there.
  Eigen::Matrix2d ideal_by_raw = Eigen::Matrix2d::Identity();
  if (!camera.Undistort(view.raw_px, &ideal_by_raw)) ideal_by_raw.setIdentity();
  const Eigen::Matrix2d lower = view.covariance_px2.llt().matrixL();
  whiten = lower.triangularView<Eigen::Lower>().solve(ideal_by_raw) / noise_scale;
}

BundleCameras::BundleCameras(const BundleFrame& frame, const double* pose, const double* left_z,
                             const double* right_z)
    : translation_m(pose[3], pose[4], pose[5]) {
  const BundleSetting& setting = *frame.setting;
  const auto shifted = [](const optics::CameraModel& camera, const IntrinsicPrior& prior, const double* z) {
    return CameraOf(Intrinsics(camera) + prior.root * Eigen::Map<const IntrinsicVector>(z), camera);
  };
  left = shifted(setting.left, setting.left_prior, left_z);
  right = shifted(setting.right, setting.right_prior, right_z);
  const Vector3d w(pose[0], pose[1], pose[2]);
  const double angle = w.norm();
  const Matrix3d skew = base::Skew(w);
  // Series below 1e-4 rad: the closed forms cancel there, the next terms are 1e-17.
  const bool is_small = angle < 1e-4;
  const double a = is_small ? 0.5 - angle * angle / 24 : (1 - std::cos(angle)) / (angle * angle);
  const double b = is_small ? 1.0 / 6 : (angle - std::sin(angle)) / (angle * angle * angle);
  const double c = is_small ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  rotation = (Matrix3d::Identity() + c * skew + a * skew * skew) * frame.rotation;
  turn_jacobian = Matrix3d::Identity() + a * skew + b * skew * skew;
}

DirectionChart::DirectionChart(const Vector3d& direction) : around(direction.normalized()) {
  const Vector3d first = around.unitOrthogonal();
  tangent << first, around.cross(first);
}

Vector3d DirectionChart::Direction(const double* steps, Eigen::Matrix<double, 3, 2>* jacobian) const {
  const Vector3d sum = around + tangent * Eigen::Vector2d(steps[0], steps[1]);
  const double length = sum.norm();
  const Vector3d unit = sum / length;
  if (jacobian != nullptr) *jacobian = (tangent - unit * (unit.transpose() * tangent)) / length;
  return unit;
}

BarCost::BarCost(const BundleFrame& frame, const StereoBar& bar, const Vector3d& direction)
    : frame_(frame),
      offset_m_(frame.setting->targets[bar.target].leds_m),
      length_sigma_(frame.setting->bar_sigma_m / frame.setting->targets[bar.target].LengthM()),
      left_(Whitened(bar.left, frame.setting->left, frame.setting->noise_scale)),
      right_(Whitened(bar.right, frame.setting->right, frame.setting->noise_scale)),
      chart_(direction) {
  double mean_m = 0;
  for (const double place_m : offset_m_) mean_m += place_m / base::kLedCount;
  for (double& place_m : offset_m_) place_m -= mean_m;
}

bool BarCost::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  const BundleCameras cameras(frame_, parameters[0], parameters[1], parameters[2]);
  const double stretch = 1 + length_sigma_ * parameters[3][0];
  const Vector3d centre(parameters[4][0], parameters[4][1], parameters[4][2]);
  Eigen::Matrix<double, 3, 2> by_steps;
  const Vector3d direction = chart_.Direction(parameters[4] + 3, &by_steps);
  LedTerm term;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const double place_m = stretch * offset_m_[i];
    if (!host::Evaluate(frame_, cameras, centre + place_m * direction, {&left_[i], &right_[i]}, term))
      return false;
    const auto row = static_cast<Eigen::Index>(4 * i);
    Eigen::Map<Eigen::Vector4d>(residuals + row) = term.residual;
    Eigen::Matrix<double, 4, kBarSize> by_bar;
    by_bar << term.by_point, place_m * term.by_point * by_steps;
    Store<kBarResiduals>(jacobians, 0, row, term.by_pose);
    Store<kBarResiduals>(jacobians, 1, row, term.by_left);
    Store<kBarResiduals>(jacobians, 2, row, term.by_right);
    Store<kBarResiduals>(jacobians, 3, row,
                         Eigen::Vector4d(length_sigma_ * offset_m_[i] * term.by_point * direction));
    Store<kBarResiduals>(jacobians, 4, row, by_bar);
  }
  return true;
}

double BarCost::SquaredPx(const double* residuals) const {
  double sum = 0;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const Eigen::Map<const Eigen::Vector4d> led(residuals + 4 * i);
    sum += (left_[i].whiten.inverse() * led.head<2>()).squaredNorm() +
           (right_[i].whiten.inverse() * led.tail<2>()).squaredNorm();
  }
  return sum;
}

PointCost::PointCost(const BundleFrame& frame, const StereoPoint& point)
    : frame_(frame),
      left_(point.left, frame.setting->left, frame.setting->noise_scale),
      right_(point.right, frame.setting->right, frame.setting->noise_scale) {}

bool PointCost::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  const BundleCameras cameras(frame_, parameters[0], parameters[1], parameters[2]);
  LedTerm term;
  const Vector3d point(parameters[3][0], parameters[3][1], parameters[3][2]);
  if (!host::Evaluate(frame_, cameras, point, {&left_, &right_}, term)) return false;
  Eigen::Map<Eigen::Vector4d>{residuals} = term.residual;
  Store<kPointResiduals>(jacobians, 0, 0, term.by_pose);
  Store<kPointResiduals>(jacobians, 1, 0, term.by_left);
  Store<kPointResiduals>(jacobians, 2, 0, term.by_right);
  Store<kPointResiduals>(jacobians, 3, 0, term.by_point);
  return true;
}

}  // namespace adit::host
