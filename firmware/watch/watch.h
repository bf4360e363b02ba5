// PointSet by PointSet -> does the calibration still hold?
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/optics/rig.h"
#include "firmware/stereo/point_set.h"
#include "firmware/stereo/view.h"
#include "firmware/watch/bar_view.h"
#include "firmware/watch/information.h"
#include "firmware/watch/reference_lights.h"

namespace adit::watch {

/// "Seconds" are seconds of tracking: rate_hz pairs with at least one target measured in full, or three fixed
/// LEDs in view.
struct WatchOptions {
  double rate_hz = 60;
  int learn_s = 300;  ///< what a target's reference is learned from; at least kWindowS
  /// What a centroid is off by at one place of the image and no covariance of noise holds: the phase bias of
  /// the detection at a peak of 200 DN (rms), whose centroids scatter by up to 1.04 times the bound of 0.0084
  /// px over all phases (tests/bench/centroid_table). If it is more, the spread of the residuals tells.
  double bias_px = 0.0025;
  /// How far the cameras have parted or sunk since the reference, 1 sigma an axis: 9 m of steel over 0.3 K. A
  /// turn has to show beside such a shift; a shift of ten times this looks like a turn and is called,
  /// rightly.
  double shift_sigma_m = 3e-5;
  /// A turn of this much, 1 sigma an axis, is no change: lens and air.
  double allowance_rad = 0.5e-6;
  std::vector<Eigen::Vector3d> lights_b_m;  ///< fixed LEDs, if there are any: rig frame, known to a few px
};

enum class Verdict : std::uint8_t {
  kLearning,  ///< no reference yet; so far nothing contradicts the calibration
  kHolds,     ///< no change against the reference
  kChanged,   ///< the right camera has turned against the left one
};

/// What the watch found in the last seconds of tracking. Trivially copyable.
struct Finding {
  Verdict verdict = Verdict::kLearning;
  double tracked_s = 0;     ///< since the start
  std::uint32_t wrong = 0;  ///< views left out since the start: no motion of the camera explains them
  /// The turn since the reference, or since the calibration for targets without one: rotation vector in the
  /// right camera's frame (x pitch, y yaw, z roll). Exp(turn_rad) R_r_l is the corrected rotation.
  std::array<double, 3> turn_rad{};
  std::array<double, 3> sigma_rad{};
  double significance = 0;  ///< the largest of |turn_rad| / sigma_rad
};

/// Estimates the turn of the right camera from the rigid fits' residuals of normal traffic.
///
/// Pitch and roll show in the epipolar residuals at once. Yaw leaves the rays crossing and moves them along
/// the depth, dz = z^2 yaw / base: it shows in the length of the bars alone, as z yaw / base, and parts from
/// a change of scale (base, bar) by how it grows with the distance.
///
/// A calibration is good to some 10 urad of yaw, a bar to 1e-4 of its length: against these a turn of 10 urad
/// is nothing. So what is tested is the *change* since a reference, each target's own apparent motion,
/// learned in its first learn_s seconds; its bar's length error and most of what the intrinsics are off by
/// cancel. Until it is learned, and for directions in which its traffic told nothing, the calibration with
/// its own covariance is the reference, so that a rig that was knocked over night is found too. What is left
/// of `kWindowS` seconds of residuals after the reference gives, by weighted least squares with the bars'
/// places projected out, the change with its covariance: noise (raised to what the residuals show, if that is
/// more), centroid bias, the reference's own uncertainty, the rig's shift. Once a second of tracking it is
/// tested: an axis beyond kAlarm sigmas calls kChanged. Without a change, and if errors are what WatchOptions
/// say, that has the probability 3 * 6.7e-8 a test; `adit evaluate --suite watch --case quiet` counts how
/// often it comes. kChanged ends when all axes are below kClear sigmas with as much evidence as called it;
/// references are not learned meanwhile.
///
/// Fixed LEDs (WatchOptions::lights_b_m) add what they tell, with a reference of their own that is learned in
/// the same time: with them a change is also found while nothing else is about.
///
/// The turn is that of the right camera relative to the left: a yaw or pitch of the left one shows as the
/// opposite. No allocation after construction; one thread.
class Watch {
 public:
  static constexpr int kWindowS = 29;
  static constexpr double kAlarm = 5.4;
  static constexpr double kClear = 3;

  /// `calibration_covariance`: of (rotation vector in the right camera's frame, translation of T_r_l), as the
  /// rig file states it.
  Watch(const optics::Rig& rig, const std::vector<base::Target>& targets, const WatchOptions& options,
        const MotionMatrix& calibration_covariance);

  /// One pair. Of its targets only those that were measured in full (kTracked) count.
  void Add(const stereo::PointSet& set);

  const Finding& Latest() const { return finding_; }

 private:
  /// The apparent motion of one target, from what it is measured later.
  struct Reference {
    Motion motion = Motion::Zero();
    MotionMatrix by_prior;  ///< error of `motion` by the calibration's error
    MotionMatrix by_noise;  ///< covariance of `motion` from the noise of the learning
    bool learned = false;
  };
  struct Lane {
    BarView view;
    std::array<Information, kWindowS> window;  ///< one a second of tracking
    Information learning;
    int learning_pairs = 0;
    Reference reference;
  };

  bool Look(std::size_t target, const stereo::PointSet& set, const stereo::TargetPoints& points);
  void Close(std::size_t target, bool stayed);
  void EndSecond();
  void EndSecondOfLights();
  void Test();
  void Judge(const Eigen::Vector3d& turn_rad, const Eigen::Matrix3d& covariance);
  void Learn(Lane& lane) const;

  stereo::Views views_;
  std::vector<base::Target> targets_;
  WatchOptions options_;
  MotionMatrix prior_covariance_, prior_;  ///< of the reference that is the calibration itself
  MotionMatrix change_prior_;              ///< information on the change: it turns freely, and hardly shifts
  std::vector<Lane> lanes_;
  ReferenceLights lights_;
  std::array<Information, kWindowS> lights_window_;
  int lights_learned_s_ = 0;  ///< seconds that their reference has been learned from
  std::size_t slot_ = 0;      ///< of the present second
  int second_pairs_ = 0;
  double alarm_sigma_rad_ = 0;  ///< of the yaw, when the alarm was called
  Finding finding_;
};

}  // namespace adit::watch
