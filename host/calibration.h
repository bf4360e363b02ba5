// The calibration of a rig from bars that both cameras identified (seed 4.3.3.2, figure 4.9).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/base/target.h"
#include "firmware/optics/rig.h"
#include "host/stereo_bar.h"

namespace adit::host {

struct CalibrationInput {
  std::string name;  ///< stands for the data in messages: the recording
  optics::CameraModel left, right;
  std::vector<base::Target> targets;
  std::vector<StereoBar> bars;  ///< candidates, wrong pairs among them
};

struct CalibrationOptions {
  double similarity_max_rad = 1.05;  ///< 60 degrees: a convergent rig sees a leaning bar from two sides
  std::size_t bars_min = 20;         ///< fewer do not average their noise
};

/// How good a calibration is, as far as its own data tell. A low `rms_px` does not reveal wrong intrinsics.
struct CalibrationQuality {
  std::size_t bars_seen = 0;    ///< pairs of a frame and a target with a candidate
  std::size_t bars_used = 0;    ///< right pairs in the final adjustment
  double rms_px = 0;            ///< of one image coordinate
  double sigma0 = 0;            ///< residuals against the centroids' own covariances; 1 = as promised
  double baseline_m = 0;        ///< between the projection centres
  double baseline_sigma_m = 0;  ///< one standard deviation
  Eigen::Vector3d sigma_rad;    ///< relative rotation about the right camera's x (pitch), y (yaw), z (roll)
  double bar_bias_m = 0;        ///< mean of measured minus true bar length, LEDs triangulated on their own
  double bar_rms_m = 0;         ///< rms of the same
  double nearest_m = 0, farthest_m = 0;                  ///< distances of the bars used
  double coverage_left_pct = 0, coverage_right_pct = 0;  ///< of 8 x 6 image cells, those with an LED
};

struct Calibration {
  optics::Rig rig;
  Eigen::Matrix<double, 6, 6> covariance;  ///< of (rotation vector, right camera frame: rad, translation: m)
  CalibrationQuality quality;
  base::TimeNs newest_bar_ns = 0;  ///< mid-exposure of the last bar used
};

/// Similarity check, robust 8-point essential matrix, the pose in front of both cameras, scale from the known
/// bars, then bundle adjustment with rigid bars, wrong pairs left out and refitted. The covariance is that of
/// the centroids, propagated, times sigma0^2 where sigma0 exceeds 1. The result does not depend on the order
/// of calls or on time: the same bars give the same digits.
///
/// Declines, with the reason: fewer than `bars_min` bars, bars without a common epipolar geometry, cameras
/// exchanged (cam0 must stand left of cam1), an adjustment that does not converge, and bars so concentrated
/// that the relative yaw stays less certain than 1 mrad or the baseline than 2 %.
base::Result<Calibration> Calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace adit::host
