// Where a body is, six degrees of freedom.
#pragma once

#include <Eigen/Core>

#include "firmware/base/pose.h"
#include "firmware/base/symmetric.h"

namespace adit::track {

/// Worse turns (1 sigma, all axes together; 1 degree) are not told: nobody steers by them.
inline constexpr double kTurnSigmaMaxRad = 0.02;

struct BodyPose {
  base::Pose<base::Rig, base::BodyFrame> T_b_t;
  /// Of (origin of t in b: m, small rotation of the body in the axes of b: rad).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// The covariance of the pose by another point of the body, `arm_b_m` from the present one: a turn moves it.
inline Eigen::Matrix<double, 6, 6> MovedCovariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                                   const Eigen::Vector3d& arm_b_m) {
  Eigen::Matrix<double, 6, 6> by_pose = Eigen::Matrix<double, 6, 6>::Identity();
  by_pose.topRightCorner<3, 3>() = -base::Skew(arm_b_m);
  return base::Congruence(by_pose, covariance);
}

}  // namespace adit::track
