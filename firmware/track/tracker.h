// PointSet -> TargetState: every target through time. Without a filter a state is the measurement, dated.
#pragma once

#include <optional>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/stereo/expectation.h"
#include "firmware/stereo/point_set.h"
#include "firmware/track/bar_filter.h"
#include "firmware/track/target_state.h"

namespace adit::track {

/// Follows every target with a BarFilter. A target is locked from the second of two measurements that fit one
/// another on, and until MotionOptions say that its place is no longer known. One thread; no allocation after
/// construction.
class Tracker {
 public:
  /// `targets` as the locator has them.
  explicit Tracker(const std::vector<base::Target>& targets, const MotionOptions& motion = {});

  /// `points` of one pair; pairs in the order of their exposures. A pair that is not later than the one
  /// before starts every target anew.
  void Track(const stereo::PointSet& points, TargetStateSet& out);

  /// Where each target is expected in a pair that is exposed after the last one tracked; only locked targets
  /// are.
  void Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const;

 private:
  /// One target: what is known of it.
  struct Trail {
    double centre_m = 0, epicenter_m = 0;     ///< along the bar from LED 1
    std::optional<BarFilter> filter;          ///< of the centre
    bool confirmed = false;                   ///< by a second measurement
    base::TimeNs measured_ns = base::kNever;  ///< last exposure that went into the filter
    base::TimeNs last_seen_ns = base::kNever;
  };

  void Follow(Trail& trail, base::TimeNs exposure_ns, const stereo::TargetPoints& points) const;
  std::optional<BarFilter> LockedAt(const Trail& trail, base::TimeNs exposure_ns) const;

  MotionOptions motion_;
  std::vector<Trail> trails_;
};

}  // namespace adit::track
