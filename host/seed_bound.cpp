#include "host/seed_bound.h"

#include <Eigen/Dense>
#include <cmath>

#include "drivers/sim/projection.h"
#include "firmware/base/require.h"
#include "host/calibration_bound.h"
#include "host/rig_uncertainty.h"

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRig = optics::kRigParameters;
using RigVector = Eigen::Matrix<double, kRig, 1>;

// Large against rounding, small against the curvature of any lens and pose.
constexpr double kStepM = 1e-4, kStepRad = 1e-6;
RigVector StepSizes() {
  IntrinsicVector camera;
  camera << 0.01, 0.01, 0.01, 0.01, 1e-5, 1e-4, 1e-6, 1e-6;
  RigVector steps;
  steps << Vector3d::Constant(kStepRad), Vector3d::Constant(kStepM), camera, camera;
  return steps;
}

/// Derivatives of the 16 coordinates of a bar: LED by LED, left u v, right u v.
struct BarSlopes {
  Eigen::Matrix<double, 4 * base::kLedCount, 3> by_point;  ///< of an LED's rows by its own place
  Eigen::Matrix<double, 4 * base::kLedCount, kRig> by_rig;
  Eigen::Matrix<double, 4 * base::kLedCount, 5> by_bar;  ///< centre (3), direction (2)
  Eigen::Matrix<double, 3, 2> tangent;
  double centre_m = 0;  ///< place of the LEDs' mean along the bar
};

/// Left u, v, right u, v.
Eigen::Vector4d Pixels(const optics::Rig& rig, const Vector3d& point_l_m) {
  Eigen::Vector4d px;
  px << *sim::ProjectPoint(rig.left, point_l_m), *sim::ProjectPoint(rig.right, rig.T_r_l * point_l_m);
  return px;
}

BarSlopes SlopesOf(const optics::Rig& rig, const base::Target& target, const BarPose& pose) {
  BarSlopes slopes;
  slopes.tangent.col(0) = pose.direction_b.unitOrthogonal();
  slopes.tangent.col(1) = pose.direction_b.cross(slopes.tangent.col(0));
  for (const double led_m : target.leds_m) slopes.centre_m += led_m / base::kLedCount;
  const RigVector sizes = StepSizes();
  for (int k = 0; k < kRig; ++k) {
    const optics::Rig up = Moved(rig, sizes[k] * RigVector::Unit(k)),
                      down = Moved(rig, -sizes[k] * RigVector::Unit(k));
    for (Eigen::Index i = 0; i < base::kLedCount; ++i) {
      const Vector3d point = pose.Point(target.leds_m[static_cast<std::size_t>(i)]);
      slopes.by_rig.block<4, 1>(4 * i, k) = (Pixels(up, point) - Pixels(down, point)) / (2 * sizes[k]);
    }
  }
  for (Eigen::Index i = 0; i < base::kLedCount; ++i) {
    const double led_m = target.leds_m[static_cast<std::size_t>(i)];
    const Vector3d point = pose.Point(led_m);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = kStepM * Vector3d::Unit(axis);
      slopes.by_point.block<4, 1>(4 * i, axis) =
          (Pixels(rig, point + step) - Pixels(rig, point - step)) / (2 * kStepM);
    }
    slopes.by_bar.block<4, 3>(4 * i, 0) = slopes.by_point.block<4, 3>(4 * i, 0);
    slopes.by_bar.block<4, 2>(4 * i, 3) =
        (led_m - slopes.centre_m) * slopes.by_point.block<4, 3>(4 * i, 0) * slopes.tangent;
  }
  return slopes;
}

/// A quantity measured with a wrong rig and noisy centroids: what moves it.
template <int kSize>
struct Reach {
  Eigen::Matrix<double, kSize, kSize> noise;  ///< covariance for centroids of 1 px
  Eigen::Matrix<double, kSize, kRig> by_rig;  ///< error of the quantity by the rig's error
};

/// Least squares over the bar: y = centre and direction, then the epicenter.
Reach<3> EpicenterReach(const BarSlopes& s, const base::Target& target) {
  const Eigen::Matrix<double, 5, 5> inverse = (s.by_bar.transpose() * s.by_bar).inverse();
  Eigen::Matrix<double, 3, 5> out;
  out << Matrix3d::Identity(), (target.epicenter_m - s.centre_m) * s.tangent;
  return {out * inverse * out.transpose(), -out * inverse * s.by_bar.transpose() * s.by_rig};
}

/// Length from LED 1 to LED 4, each triangulated on its own.
Reach<1> LengthReach(const BarSlopes& s, const Vector3d& direction) {
  Reach<1> reach;
  reach.noise.setZero(), reach.by_rig.setZero();
  for (const Eigen::Index i : {Eigen::Index{0}, Eigen::Index{3}}) {
    const Eigen::Matrix<double, 4, 3> slope = s.by_point.block<4, 3>(4 * i, 0);
    const Matrix3d inverse = (slope.transpose() * slope).inverse();
    const double sign = i == 0 ? -1 : 1;
    reach.noise += direction.transpose() * inverse * direction;
    reach.by_rig -=
        sign * direction.transpose() * inverse * slope.transpose() * s.by_rig.block<4, kRig>(4 * i, 0);
  }
  return reach;
}

}  // namespace

PoseInformation BarInformation(const optics::Rig& rig, const base::Target& target, const BarPose& pose) {
  const BarSlopes s = SlopesOf(rig, target, pose);
  const auto by_pose = s.by_rig.leftCols<6>();
  const Eigen::Matrix<double, 5, 6> mixed = s.by_bar.transpose() * by_pose;
  return by_pose.transpose() * by_pose -
         mixed.transpose() * (s.by_bar.transpose() * s.by_bar).inverse() * mixed;
}

optics::RigCovariance WandBound(const optics::Rig& rig, const SeedSetup& setup,
                                std::span<const BarPose> poses) {
  CalibrationPlan plan;
  plan.leds_m = setup.bar.leds_m;
  plan.noise_px = setup.noise_px, plan.bar_sigma_m = setup.bar_sigma_m;
  CalibrationDraw draw;
  draw.rig = {Intrinsics(rig.left), Intrinsics(rig.right), rig.T_r_l.rotation, rig.T_r_l.translation_m};
  draw.input.left_prior = PriorOf(setup.lens, rig.left);
  draw.input.right_prior = PriorOf(setup.lens, rig.right);
  for (const BarPose& pose : poses) draw.bars.push_back({pose.led1_b_m, pose.direction_b});
  const auto bound = CalibrationBound(plan, draw);
  ADIT_REQUIRE(bound.has_value());
  return *bound;
}

PlaceBound BoundAt(const optics::Rig& rig, const optics::RigCovariance& calibration,
                   const base::Target& target, std::span<const BarPose> poses, double noise_px) {
  const auto frames = static_cast<double>(poses.size());
  const Matrix3d R_m_b = MiddleFrame(rig).R_b_m.transpose();
  Eigen::Matrix<double, 3, kRig> position_by_rig = Eigen::Matrix<double, 3, kRig>::Zero();
  Eigen::Matrix<double, 1, kRig> length_by_rig = Eigen::Matrix<double, 1, kRig>::Zero();
  Matrix3d position_noise = Matrix3d::Zero();
  double length_noise = 0, length_systematic = 0;
  Vector3d mean_m = Vector3d::Zero(), moved_m2 = Vector3d::Zero();
  for (const BarPose& pose : poses) mean_m += R_m_b * pose.Point(target.epicenter_m) / frames;
  for (const BarPose& pose : poses) {
    const BarSlopes s = SlopesOf(rig, target, pose);
    const Reach<3> position = EpicenterReach(s, target);
    const Reach<1> length = LengthReach(s, pose.direction_b);
    moved_m2 += (R_m_b * pose.Point(target.epicenter_m) - mean_m).cwiseAbs2() / (frames - 1);
    position_by_rig += position.by_rig / frames, position_noise += position.noise / frames;
    length_by_rig += length.by_rig / frames, length_noise += length.noise(0, 0) / frames;
    length_systematic += (length.by_rig * calibration * length.by_rig.transpose())(0, 0) / frames;
  }
  const double px2 = noise_px * noise_px;
  const double mean_systematic = (length_by_rig * calibration * length_by_rig.transpose())(0, 0);
  PlaceBound bound;
  bound.bar_bias_m = std::sqrt(mean_systematic + px2 * length_noise / frames);
  // A wrong rig also spreads the lengths of a bar that turns.
  bound.bar_sigma_m = std::sqrt(px2 * length_noise + length_systematic - mean_systematic);
  // The rms of noisy lengths is longer than their mean by this.
  const double lengthening_m = bound.bar_sigma_m * bound.bar_sigma_m / (2 * target.LengthM());
  bound.half_bar_m = 0.5 * std::hypot(bound.bar_bias_m, lengthening_m);
  bound.position_m = std::sqrt((position_by_rig * calibration * position_by_rig.transpose()).trace() +
                               px2 * position_noise.trace() / frames);
  bound.sigma_m =
      (Vector3d((px2 * R_m_b * position_noise * R_m_b.transpose()).diagonal()) + moved_m2).cwiseSqrt();
  return bound;
}

}  // namespace adit::host
