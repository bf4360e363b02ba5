// Bundle adjustment of one camera: its intrinsics and the board's pose in every image to all measured
// corners.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "firmware/optics/camera_model.h"
#include "host/board_finder.h"
#include "host/intrinsic_parameters.h"

namespace adit::host {

/// Maps a point of the board (m, z = 0) into the camera's frame.
struct BoardPose {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();  ///< rotation vector
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
};

/// What one view says of the intrinsics, its pose eliminated (Schur complement), for corners of 1 px standard
/// deviation a coordinate: its part of the normal equations at the solution.
struct ImageShare {
  IntrinsicMatrix information = IntrinsicMatrix::Zero();
  IntrinsicVector gradient = IntrinsicVector::Zero();  ///< sums to zero over the views of least squares
};

struct IntrinsicsBundle {
  optics::CameraModel camera;
  std::vector<BoardPose> poses;  ///< one a view
  /// Model minus measurement of every corner, as the views hold them, px; not finite for a corner that the
  /// solution puts behind the camera.
  std::vector<std::vector<Eigen::Vector2d>> residuals_px;
  std::vector<ImageShare> shares;  ///< one a view

  /// What all views say of the intrinsics: its inverse times sigma0^2 is their covariance.
  IntrinsicMatrix Information() const;
};

/// Minimises over 8 + 6 n parameters from `start` (Ceres, Schur complement on the poses), with Brown's
/// distortion k1, k2, p1, p2. `robust_px`: scale of a Cauchy loss on each corner while wrong ones may be
/// among them; empty: least squares. Declines if the solver does not converge to finite values.
std::optional<IntrinsicsBundle> AdjustIntrinsics(std::span<const BoardView> views,
                                                 const optics::CameraModel& start,
                                                 std::span<const BoardPose> poses,
                                                 std::optional<double> robust_px);

}  // namespace adit::host
