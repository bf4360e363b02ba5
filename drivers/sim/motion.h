// How the things of a scene move.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "firmware/base/pose.h"
#include "firmware/base/target.h"
#include "firmware/optics/rig.h"

namespace adit::sim {

struct Ground {};  ///< g, the frame that a scene file's positions are in
struct Mobile {};  ///< m, the frame of one moving thing

/// Where a moving thing is. Immutable; any thread may ask.
class Motion {
 public:
  virtual ~Motion() = default;
  /// T_b_m at scene time `t_s` (any finite value).
  virtual base::Pose<base::Rig, Mobile> At(double t_s) const = 0;
  /// Whether At is the same for all times.
  virtual bool AtRest() const = 0;
};

using MotionPtr = std::shared_ptr<const Motion>;

/// A place at a time. The thing's x axis points along `direction` (a unit vector); with x it has the smallest
/// turn that does so.
struct Waypoint {
  double t_s = 0;
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

enum class Curve : std::uint8_t { kLinear, kSpline };

/// Waypoints in the ground frame, ascending in time, at least one. Positions along straight lines or a
/// Catmull-Rom spline, directions along great circles. Before the first and after the last it stands; with
/// `repeat` it starts again.
struct Course {
  std::vector<Waypoint> waypoints;
  Curve curve = Curve::kLinear;
  bool repeat = false;
};
MotionPtr MakePath(const Course& course, const base::Pose<base::Rig, Ground>& T_b_g);

/// A machine that drives to and fro: from + (to - from) (1 - cos(pi t / duration)) / 2, weaving to the sides
/// (its heading follows), shaken along all three axes.
struct Drive {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero(), to_m = Eigen::Vector3d::Zero();
  double duration_s = 1;  ///< one way
  double weave_m = 0, weave_period_s = 10;
  double vibration_m = 0, vibration_hz = 20;
};
MotionPtr MakeDrive(const Drive& drive, const base::Pose<base::Rig, Ground>& T_b_g);

/// A bar waved for calibration: one random place and direction every `step_s`, such that both images hold all
/// its LEDs; directions over the whole sphere but for |z| > lean_max. Between them a spline.
struct Wave {
  double nearest_m = 15, farthest_m = 30;  ///< along the left optical axis
  double lean_max = 0.7;
  double step_s = 1.5;
  double length_s = 60;  ///< then it starts again
  std::uint64_t seed = 1;
};
/// Waypoints in the rig frame; empty if the two images share no room for the bar there.
std::vector<Waypoint> WaveBar(const Wave& wave, const base::Target& target, const optics::Rig& rig);

/// The frame `middle`: origin in the middle of the baseline, x along it, z the mean viewing direction made
/// perpendicular to it.
base::Pose<base::Rig, Ground> MiddleFrame(const optics::Rig& rig);

}  // namespace adit::sim
