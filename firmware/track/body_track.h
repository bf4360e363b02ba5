// One body through time.
#pragma once

#include <optional>
#include <vector>

#include "firmware/stereo/expectation.h"
#include "firmware/track/body.h"
#include "firmware/track/body_filter.h"
#include "firmware/track/target_state.h"

namespace adit::track {

/// What a body is followed by.
struct BodyTrackOptions {
  MotionOptions motion;
  bool filter = false;    ///< whether its state is the filter's, predicted while that knows the pose
  std::size_t index = 0;  ///< the body's place in the states: bodies follow the targets
};

/// Makes a body's state of its bars. One thread; no allocation.
class BodyTrack {
 public:
  BodyTrack(const Body& body, const std::vector<base::Target>& targets, const BodyTrackOptions& options);

  /// The state of the body in the pair of `points`; `states` says which of them the tracking believes.
  /// Tracked or recovered as the worst of its bars that are seen; lost if less than two are (kOneBar) or if
  /// they do not fit it (kGeometry).
  TargetState Track(const stereo::PointSet& points, const TargetStateSet& states);

  /// Where the body's bars are expected in a pair after the last one tracked, if it knows that better than
  /// `out` does: a bar that was lost is sought where the others say it is.
  void Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const;

 private:
  SeenBars SeenIn(const stereo::PointSet& points, const TargetStateSet& states) const;
  void Follow(base::TimeNs exposure_ns, const SeenBars& seen, const std::optional<BodyPose>& fitted);
  std::optional<BodyFilter> LockedAt(base::TimeNs exposure_ns) const;
  /// Status, reason and figures of a body whose seen bars these are.
  stereo::TargetPoints Describe(const stereo::PointSet& points, const SeenBars& seen) const;

  Body body_;
  BodyTrackOptions options_;
  std::array<double, kMaxBodyBars> epicenters_m_{};  ///< along the bars from LED 1
  std::optional<BodyFilter> filter_;
  bool confirmed_ = false;
  base::TimeNs measured_ns_ = base::kNever;
  base::TimeNs last_seen_ns_ = base::kNever;
};

}  // namespace adit::track
