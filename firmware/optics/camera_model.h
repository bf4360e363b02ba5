// Pixels <-> directions of one camera: pinhole with radial-tangential distortion (Brown 1966, as OpenCV and
// Kalibr write it). "Ideal" pixels are what the same camera would see without distortion; everything after
// the detection works in them.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace adit::optics {

/// fu, fv, cu, cv in pixels; (0,0) is the centre of the first pixel. Radial k1, k2 and tangential p1, p2 act
/// on normalised coordinates.
struct CameraModel {
  double fu_px = 0, fv_px = 0, cu_px = 0, cv_px = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  int width_px = 0, height_px = 0;

  /// Normalised ideal coordinates (x/z, y/z) -> normalised distorted ones; `jacobian` (2x2) is optional.
  Eigen::Vector2d Distort(const Eigen::Vector2d& ideal, Eigen::Matrix2d* jacobian = nullptr) const;

  /// A point in the camera's frame (m, z > 0) -> raw pixel, inside the image or not. Declines points at or
  /// behind the projection centre, and rays beyond the radius at which the radial model folds over (their
  /// pixels would be ghosts inside the image).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_m) const;

  /// Raw pixel -> ideal pixel, by Newton's method on Distort (converges quadratically for lens-like
  /// distortion; five steps end below 1e-10 px). `jacobian` = d ideal / d raw. Declines where the model folds
  /// over (beyond the fold, nearly singular, or no convergence), as it can outside the image.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& raw_px,
                                           Eigen::Matrix2d* jacobian = nullptr) const;

  /// Normalised coordinates of an ideal pixel, and back.
  Eigen::Vector2d Normalised(const Eigen::Vector2d& ideal_px) const {
    return {(ideal_px.x() - cu_px) / fu_px, (ideal_px.y() - cv_px) / fv_px};
  }
  Eigen::Vector2d Pixel(const Eigen::Vector2d& normalised) const {
    return {fu_px * normalised.x() + cu_px, fv_px * normalised.y() + cv_px};
  }

  /// The camera matrix K (3x3).
  Eigen::Matrix3d K() const;
};

}  // namespace adit::optics
