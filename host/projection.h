// What a camera makes of a point, with the derivatives that adjustments and error propagation need.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "firmware/optics/camera_model.h"
#include "host/intrinsic_parameters.h"

namespace adit::host {

struct Projection {
  Eigen::Vector2d raw_px;
  Eigen::Matrix<double, 2, 3> by_point;             ///< d raw / d point, px/m
  Eigen::Matrix<double, 2, kIntrinsics> by_camera;  ///< d raw / d intrinsics
};

/// Declines a point at or behind the projection centre. No check of the model's fold: an adjustment may pass
/// it.
std::optional<Projection> ProjectWithDerivatives(const optics::CameraModel& camera,
                                                 const Eigen::Vector3d& point_m);

}  // namespace adit::host
