// The calibration of a rig from bars that both cameras identified (seed 4.3.3.2, figure 4.9).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/base/target.h"
#include "firmware/optics/rig.h"
#include "host/coverage_gap.h"
#include "host/hold_out.h"
#include "host/intrinsic_prior.h"
#include "host/rest_lights.h"
#include "host/rig_uncertainty.h"
#include "host/stereo_bar.h"

namespace adit::host {

struct CalibrationInput {
  std::vector<std::string> recordings;  ///< their names in messages; bars and points refer to them
  optics::CameraModel left, right;
  std::vector<base::Target> targets;
  std::vector<StereoBar> bars;          ///< candidates, wrong pairs among them
  std::vector<RestLights> lights = {};  ///< at rest, one entry a recording that is asked for them
  IntrinsicPrior left_prior = {}, right_prior = {};  ///< exact: the intrinsics stay as they are
  double bar_sigma_m = 0;                            ///< standard deviation of each bar's length
};

struct CalibrationOptions {
  double similarity_max_rad = 1.05;  ///< 60 degrees: a convergent rig sees a leaning bar from two sides
  std::size_t bars_min = 20;         ///< fewer do not average their noise
  std::size_t hold_out_every = 10;   ///< every tenth bar is kept from the adjustment to test it; 0: none
};

/// A candidate that is no bar seen by both cameras.
struct WrongPair {
  std::size_t recording = 0;  ///< index into the input's
  base::TimeNs mid_exposure_ns = 0;
  std::size_t target = 0;
  std::string reason;
};

/// How good a calibration is, as far as its own data tell. A low `rms_px` does not reveal wrong intrinsics.
struct CalibrationQuality {
  std::size_t bars_seen = 0;    ///< pairs of a frame and a target with a candidate
  std::size_t bars_used = 0;    ///< right pairs in the final adjustment
  std::size_t points_used = 0;  ///< lights at rest in it
  double rms_px = 0;            ///< of one image coordinate
  double sigma0 = 0;            ///< residuals against the centroids' own covariances; 1 = as promised
  double baseline_m = 0;        ///< between the projection centres
  double baseline_sigma_m = 0;  ///< one standard deviation
  Eigen::Vector3d sigma_rad =
      Eigen::Vector3d::Zero();  ///< rotation about the right camera's x (pitch), y (yaw), z (roll)
  double bar_bias_m = 0;        ///< mean of measured minus true bar length, LEDs triangulated on their own
  double bar_rms_m = 0;         ///< rms of the same
  double nearest_m = 0, farthest_m = 0;                  ///< distances of the bars used
  double coverage_left_pct = 0, coverage_right_pct = 0;  ///< of 8 x 6 image cells, those with an LED
  double intrinsics_pull =
      0;  ///< how far the intrinsics moved from their files: rms in prior sigmas; 0: exact
  HoldOut hold_out;
  std::vector<RigPrediction> predictions;  ///< at 30, 70 and 110 m
  std::vector<CoverageGap> gaps;           ///< where the bars were not; the first is the one to wave in next
};

enum class Verdict { kGood, kUsable };

struct Calibration {
  optics::Rig rig;
  optics::RigCovariance covariance = optics::RigCovariance::Zero();
  CalibrationQuality quality;
  Verdict verdict = Verdict::kGood;
  std::vector<std::string> reservations;  ///< why it is only usable, each with the remedy
  std::vector<WrongPair> wrong;           ///< candidates left out, in order of time
  std::vector<StereoBar> bars;            ///< those used; ideal pixels by the refined cameras
  std::vector<double> distances_m;        ///< of them
  base::TimeNs newest_bar_ns = 0;         ///< mid-exposure of the last bar used
};

/// Similarity check, robust 8-point essential matrix, the pose in front of both cameras, scale from the known
/// bars, then bundle adjustment with rigid bars, their lengths and the intrinsics within their priors; wrong
/// pairs left out and refitted; then again with the lights at rest that the rig so found pairs. The
/// covariance is that of the centroids, widened by sigma0 where it exceeds 1, and of the priors, propagated.
/// The result does not depend on the order of calls or on time: the same bars give the same digits.
///
/// Declines, with the reason: fewer than `bars_min` bars, bars without a common epipolar geometry, cameras
/// exchanged (cam0 must stand left of cam1), an adjustment that does not converge, bars so concentrated
/// that the relative yaw stays less certain than 1 mrad or the baseline than 2 %, intrinsics that move by
/// more than five of their sigmas, and held-out bars that miss their length by more than predicted.
base::Result<Calibration> Calibrate(const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace adit::host
