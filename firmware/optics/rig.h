// Two calibrated cameras.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "firmware/base/pose.h"
#include "firmware/base/result.h"
#include "firmware/optics/camera_model.h"

namespace adit::optics {

/// What a calibration does not know exactly, in this order wherever it stands in a row: rotation vector of
/// exp(w) R (right camera's frame, rad), translation (m), then fu, fv, cu, cv (px), k1, k2, p1, p2 of the
/// left camera and of the right one.
constexpr int kRigParameters = 22;
using RigCovariance = Eigen::Matrix<double, kRigParameters, kRigParameters>;

/// A stereo rig. The rig frame b is the left camera's frame.
struct Rig {
  CameraModel left;
  CameraModel right;
  base::Pose<base::RightCamera, base::LeftCamera> T_r_l;
  std::string calibration_id;  ///< names this calibration wherever its results go

  double BaselineM() const { return T_r_l.translation_m.norm(); }
  /// F with x_r^T F x_l = 0 for ideal pixels (homogeneous) of the left and right image (Hartley &
  /// Zisserman 9.2).
  Eigen::Matrix3d Fundamental() const;
};

/// Reads one camera: EuRoC `sensor.yaml`, or OpenCV FileStorage (`camera_matrix`, `distortion_coefficients`,
/// `image_width`, `image_height`; up to 5 coefficients, k3 must be 0).
base::Result<CameraModel> LoadCamera(const std::string& path);
/// The same as EuRoC `sensor.yaml` text.
std::string FormatCamera(const CameraModel& camera);

/// Reads the key `covariance` of a rig file; empty if there is none. Refuses one that is not 22 x 22 and
/// symmetric, and negative variances.
base::Result<std::optional<RigCovariance>> LoadRigCovariance(const std::string& path);
/// The key as text.
std::string FormatRigCovariance(const RigCovariance& covariance);

/// Reads a Kalibr camchain with adit's keys. Refuses a missing or non-orthonormal T_cn_cnm1, a baseline
/// outside 0.1 to 50 m, or a right camera that does not stand to the right of the left one (a wrong baseline
/// sign).
base::Result<Rig> LoadRig(const std::string& path);
std::string FormatRig(const Rig& rig);

}  // namespace adit::optics
