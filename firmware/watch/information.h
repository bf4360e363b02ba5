// What observations say of how the right camera has moved against the calibration in use.
#pragma once

#include <Eigen/Core>

namespace adit::watch {

/// Motion of the right camera against its calibrated pose: a rotation vector in its own frame, about its
/// projection centre (rad; x pitch, y yaw, z roll), then a shift of its projection centre in the rig frame b
/// (m). With it a point p of b is seen at Exp(rotation) R_r_b (p - centre - shift).
using Motion = Eigen::Matrix<double, 6, 1>;
using MotionMatrix = Eigen::Matrix<double, 6, 6>;

/// Least squares, added up: the best motion x solves normal x = gradient.
struct Information {
  MotionMatrix normal = MotionMatrix::Zero();
  Motion gradient = Motion::Zero();
  double chi_square = 0;  ///< of the residuals with no motion
  int redundancy = 0;     ///< degrees of freedom of chi_square

  Information& operator+=(const Information& other) {
    normal += other.normal;
    gradient += other.gradient;
    chi_square += other.chi_square;
    redundancy += other.redundancy;
    return *this;
  }
};

}  // namespace adit::watch
