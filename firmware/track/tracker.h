// PointSet -> TargetState: every target through time. Without a filter a state is the measurement, dated.
#pragma once

#include "firmware/stereo/point_set.h"
#include "firmware/track/target_state.h"

namespace adit::track {

/// One thread; no allocation.
class Tracker {
 public:
  /// `points` of one pair; pairs in the order of their exposures.
  void Track(const stereo::PointSet& points, TargetStateSet& out);

 private:
  base::FixedVector<base::TimeNs, identify::kMaxTargets> last_seen_ns_;
};

}  // namespace adit::track
