// The two cameras as the stereo stage uses them: ideal pinholes with a pose.
#pragma once

#include <Eigen/Core>
#include <array>

#include "firmware/identify/sighting_set.h"
#include "firmware/optics/rig.h"

namespace adit::stereo {

/// One camera without distortion. Pixels are ideal ones (optics::CameraModel), points are in the rig frame b,
/// metres.
struct View {
  double fu_px = 0, fv_px = 0, cu_px = 0, cv_px = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R_c_b
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  /// Pixel of a point and the 2x3 derivative by it. Declines points at or behind the projection centre.
  bool Project(const Eigen::Vector3d& point_b_m, Eigen::Vector2d& px,
               Eigen::Matrix<double, 2, 3>& slope) const;

  /// Projection centre in b.
  Eigen::Vector3d CentreM() const { return -(rotation.transpose() * translation_m); }
  /// Direction in b, not normalised: depth 1 in the camera.
  Eigen::Vector3d Ray(const Eigen::Vector2d& ideal_px) const;
  Eigen::Vector2d Normalised(const Eigen::Vector2d& ideal_px) const {
    return {(ideal_px.x() - cu_px) / fu_px, (ideal_px.y() - cv_px) / fv_px};
  }
};

/// Left and right.
using Views = std::array<View, 2>;

Views MakeViews(const optics::Rig& rig);

/// One centroid: ideal pixel and covariance.
struct Observation {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
  bool seen = true;  ///< false: the LED is hidden in this image, and the rest is empty

  /// W with W^T W = (covariance + floor^2 I)^-1: makes residuals of unit variance. Zero if it is not seen.
  Eigen::Matrix2d Whitener(double floor_px) const;
};

/// Centroids of one LED in both images.
using ObservationPair = std::array<Observation, 2>;

inline bool SeenInBoth(const ObservationPair& pair) { return pair[0].seen && pair[1].seen; }

/// Smallest noise that is believed of any centroid: a third of the Cramer-Rao bound of a quiet CCD.
inline constexpr double kNoiseMinPx = 0.001;

}  // namespace adit::stereo
