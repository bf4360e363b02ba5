// What the tracking hands on: the state of every target at the time of the exposure.
#pragma once

#include "firmware/stereo/point_set.h"

namespace adit::track {

/// One target through time.
struct TargetState {
  stereo::TargetPoints points;  ///< status, position and covariance as measured
  base::TimeNs mid_exposure_ns = base::kNever;
  base::TimeNs last_packet_ns = base::kNever;
  std::uint64_t trigger = 0;
  base::TimeNs last_seen_ns = base::kNever;  ///< mid-exposure of the last pair with a position
};

struct TargetStateSet {
  base::FixedVector<TargetState, identify::kMaxTargets> targets;
};

}  // namespace adit::track
