// PointSet -> TargetState: every target through time. Without a filter a state is the measurement, dated.
#pragma once

#include <optional>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/stereo/expectation.h"
#include "firmware/stereo/point_set.h"
#include "firmware/track/bar_filter.h"
#include "firmware/track/body.h"
#include "firmware/track/body_track.h"
#include "firmware/track/motion_options.h"
#include "firmware/track/target_state.h"

namespace adit::track {

struct TrackerOptions {
  MotionOptions motion;
  /// Whether states are the filter's: smoothed, and bridged as kPredicted while a lock lasts.
  bool filter = false;
  std::vector<Body> bodies;  ///< made of the targets; together at most identify::kMaxTargets
};

/// Follows every target with a BarFilter. A target is locked from the second of two measurements that fit one
/// another on, and until MotionOptions say that its place is no longer known.
///
/// A measurement of a locked target that does not fit is not believed, with or without the filter: the state
/// is lost (kJump). If the next one fits the first, within MotionOptions::confirm_max_ns, the target did
/// jump, and the track goes on from there: a target that comes back elsewhere is lost for one pair more.
///
/// One thread; no allocation after construction.
class Tracker {
 public:
  /// `targets` as the locator has them.
  explicit Tracker(const std::vector<base::Target>& targets, const TrackerOptions& options = {});

  /// `points` of one pair; pairs in the order of their exposures. A pair that is not later than the one
  /// before starts every target anew. One state for every target, then one for every body.
  void Track(const stereo::PointSet& points, TargetStateSet& out);

  /// Where each target is expected in a pair that is exposed after the last one tracked; only locked targets
  /// are, and bars of a body that the other bars hold in its place. Of others it says where they were seen,
  /// if that is recent. What `out` holds beyond the targets stays.
  void Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const;

  /// The epicenter at `time_ns`, by the filter: between two pairs, or when a machine gets to hear of it.
  /// Nothing if the target is not locked then, or if the time is before the last pair.
  std::optional<BarPlace> PlaceAt(std::size_t target, base::TimeNs time_ns) const;

 private:
  /// One target: what is known of it.
  struct Trail {
    double centre_m = 0, epicenter_m = 0;     ///< along the bar from LED 1
    std::optional<BarFilter> filter;          ///< of the centre
    bool confirmed = false;                   ///< by a second measurement
    base::TimeNs measured_ns = base::kNever;  ///< last exposure that went into the filter
    std::optional<BarFilter> rival;           ///< of a measurement that did not fit
    stereo::LedFlux flux_dn{};                ///< of the LEDs
    base::TimeNs flux_ns = base::kNever;      ///< when that was last so
    base::TimeNs last_seen_ns = base::kNever;
  };

  void Advance(Trail& trail, base::TimeNs exposure_ns) const;
  bool Take(Trail& trail, base::TimeNs exposure_ns, const BarPlace& measured) const;
  void TakeFlux(Trail& trail, const stereo::TargetPoints& measured) const;
  bool Fits(const std::optional<BarFilter>& filter, const BarPlace& measured) const;
  bool IsLocked(const Trail& trail, const BarFilter& filter) const;
  std::optional<BarFilter> LockedAt(const Trail& trail, base::TimeNs exposure_ns) const;
  stereo::TargetPoints Judge(Trail& trail, base::TimeNs exposure_ns,
                             const stereo::TargetPoints& measured) const;

  TrackerOptions options_;
  std::vector<base::Target> targets_;
  std::vector<Trail> trails_;
  std::vector<BodyTrack> bodies_;
};

}  // namespace adit::track
