// The simulator's own camera: truth must not come from the code that it tests.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "firmware/optics/camera_model.h"

namespace adit::sim {

/// A point in the camera's frame (m) -> pixel, pinhole with Brown's distortion (D. C. Brown, "Decentering
/// distortion of lenses", 1966): x_d = x (1 + k1 r^2 + k2 r^4) + 2 p1 x y + p2 (r^2 + 2 x^2), y_d likewise.
/// Declines points that are not at least 1 cm in front of the camera, and angles beyond which the radial
/// polynomial folds back into the image.
std::optional<Eigen::Vector2d> ProjectPoint(const optics::CameraModel& camera,
                                            const Eigen::Vector3d& point_m);

}  // namespace adit::sim
