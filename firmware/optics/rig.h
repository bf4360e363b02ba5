// Two calibrated cameras.
#pragma once

#include <Eigen/Core>
#include <string>

#include "firmware/base/pose.h"
#include "firmware/base/result.h"
#include "firmware/optics/camera_model.h"

namespace adit::optics {

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

/// Reads a Kalibr camchain with adit's keys. Refuses a missing or non-orthonormal T_cn_cnm1, a baseline
/// outside 0.1 to 50 m, or a right camera that does not stand to the right of the left one (a wrong baseline
/// sign).
base::Result<Rig> LoadRig(const std::string& path);
std::string FormatRig(const Rig& rig);

}  // namespace adit::optics
