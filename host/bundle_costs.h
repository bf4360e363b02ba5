// The terms of the rig's bundle adjustment: LED residuals of a bar or a point in both images, with analytic
// derivatives.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>

#include "host/bundle.h"

namespace adit::host {

constexpr int kPoseSize = 6;       ///< rotation vector in the right camera's frame, translation m
constexpr int kBarSize = 5;        ///< centre m, direction in the tangent plane of its start
constexpr int kBarResiduals = 16;  ///< 4 LEDs x 2 images x 2
constexpr int kPointSize = 3, kPointResiduals = 4;

/// What all terms share. The rotation is exp(pose[0..2]) times `rotation`.
struct BundleFrame {
  const BundleSetting* setting;
  Eigen::Matrix3d rotation;
};

/// A measured centroid and the matrix that makes its residual one of unit covariance.
struct WhitenedView {
  Eigen::Vector2d raw_px;
  Eigen::Matrix2d whiten;

  WhitenedView(const LedView& view, const optics::CameraModel& camera, double noise_scale);
};

/// Cameras and pose at one set of parameters.
struct BundleCameras {
  optics::CameraModel left, right;
  Eigen::Matrix3d rotation, turn_jacobian;  ///< R, and d exp(w) = [turn_jacobian dw]x exp(w)
  Eigen::Vector3d translation_m;

  BundleCameras(const BundleFrame& frame, const double* pose, const double* left_z, const double* right_z);
};

/// A direction near `around`: the normalised sum of it and two steps in its tangent plane.
struct DirectionChart {
  Eigen::Vector3d around;
  Eigen::Matrix<double, 3, 2> tangent;

  explicit DirectionChart(const Eigen::Vector3d& direction);
  Eigen::Vector3d Direction(const double* steps, Eigen::Matrix<double, 3, 2>* jacobian = nullptr) const;
};

/// Parameters: pose, left z, right z, length step (in sigmas), bar.
class BarCost
    : public ceres::SizedCostFunction<kBarResiduals, kPoseSize, kIntrinsics, kIntrinsics, 1, kBarSize> {
 public:
  BarCost(const BundleFrame& frame, const StereoBar& bar, const Eigen::Vector3d& direction);
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

  const DirectionChart& Chart() const { return chart_; }
  /// Squared pixels of whitened residuals.
  double SquaredPx(const double* residuals) const;

 private:
  BundleFrame frame_;
  std::array<double, base::kLedCount> offset_m_;  // of the LEDs from their mean
  double length_sigma_;                           // relative
  std::array<WhitenedView, base::kLedCount> left_, right_;
  DirectionChart chart_;
};

/// Parameters: pose, left z, right z, point.
class PointCost
    : public ceres::SizedCostFunction<kPointResiduals, kPoseSize, kIntrinsics, kIntrinsics, kPointSize> {
 public:
  PointCost(const BundleFrame& frame, const StereoPoint& point);
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  BundleFrame frame_;
  WhitenedView left_, right_;
};

/// Standard normal: the prior of parameters in units of their sigma.
template <int kSize>
class UnitPrior : public ceres::SizedCostFunction<kSize, kSize> {
 public:
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    using Vector = Eigen::Matrix<double, kSize, 1>;
    Eigen::Map<Vector>{residuals} = Eigen::Map<const Vector>(parameters[0]);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<Eigen::Matrix<double, kSize, kSize, kSize == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(
          jacobians[0])
          .setIdentity();
    return true;
  }
};

}  // namespace adit::host
