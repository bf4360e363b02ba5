// What the tracking hands on: the state of every target at the time of the exposure.
#pragma once

#include <optional>

#include "firmware/stereo/point_set.h"
#include "firmware/track/body_pose.h"

namespace adit::track {

/// One target or body through time.
struct TargetState {
  /// Status, position and covariance. Of a body: its origin is the epicenter, its x axis the direction; in
  /// the place of the LEDs stand its origin and the points 1 m along its x, y and z axes.
  stereo::TargetPoints points;
  base::TimeNs mid_exposure_ns = base::kNever;
  base::TimeNs last_packet_ns = base::kNever;
  std::uint64_t trigger = 0;
  base::TimeNs last_seen_ns = base::kNever;  ///< mid-exposure of the last pair that showed it
  std::optional<BodyPose> pose;              ///< of a body that is not lost
};

/// The targets in the model list's order, then the bodies.
struct TargetStateSet {
  base::FixedVector<TargetState, identify::kMaxTargets> targets;
};

}  // namespace adit::track
