// Two machines that pass before a rig whose right camera has moved: truth for the campaign of the watch.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "firmware/pipeline/pipeline.h"
#include "host/seed_world.h"

namespace adit::host {

/// How well the machines are seen.
struct TrafficPlan {
  double rate_hz = 60;
  double noise_px = 0.0084;  ///< of every coordinate, stated by the blobs
  /// rms of what depends on where on the pixel an LED falls and no covariance states: the most that the
  /// box's detection leaves at a peak of 200 DN (1.04 times the bound over all phases).
  double phase_bias_px = 0.0025;
  double nearest_m = 20, farthest_m = 80;
  double bar_sigma_m = 1e-4;  ///< what each bar's true length is off by
};

/// Two bars of 1.5 m, each on a machine that goes to and fro with a period and a sway of its own. Base 9 m,
/// lenses without distortion; the projection is the simulator's own. What follows the detection is the box's.
class WatchTraffic {
 public:
  WatchTraffic(const TrafficPlan& plan, std::uint64_t seed);

  static std::array<base::Target, 2> Targets();
  /// As calibrated.
  const optics::Rig& Calibrated() const { return calibrated_; }
  /// From now on the right camera is turned and shifted by this against its calibration (watch::Motion).
  void Move(const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_b_m);
  /// The next pair, identified and located with the calibrated rig. Valid until the next call.
  const stereo::PointSet& Next();
  /// Of the last pair.
  std::array<BarPose, 2> Poses() const { return {PoseAt(0), PoseAt(1)}; }
  /// For what else is random.
  SeedDraw& Draw() { return draw_; }

 private:
  /// The course of one machine; every motion is a sine of its own period and phase.
  struct Course {
    double period_s = 0, phase_rad = 0;                             ///< along the tunnel
    double aside_m = 0, sway_m = 0, sway_s = 0;                     ///< across it
    double height_m = 0, tilt_rad = 0, swing_rad = 0, swing_s = 0;  ///< of the bar
  };

  double TimeS() const { return static_cast<double>(pair_) / plan_.rate_hz; }
  BarPose PoseAt(std::size_t machine) const;
  void Show(std::size_t machine);

  TrafficPlan plan_;
  optics::Rig calibrated_, real_;
  MiddleFrame frame_;
  SeedDraw draw_;
  std::array<Course, 2> courses_;
  pipeline::Pipeline pipeline_;
  std::array<double, 2> length_scale_{};
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_;  // too large for a stack
  std::unique_ptr<pipeline::PairResult> result_;
  std::uint64_t pair_ = 0;
};

}  // namespace adit::host
