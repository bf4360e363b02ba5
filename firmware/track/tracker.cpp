#include "firmware/track/tracker.h"

#include <cmath>

namespace adit::track {

using stereo::FixStatus;
using stereo::TargetPoints;

Tracker::Tracker(const std::vector<base::Target>& targets, const MotionOptions& motion) : motion_(motion) {
  ADIT_REQUIRE(targets.size() <= identify::kMaxTargets);
  for (const base::Target& target : targets) {
    Trail trail;
    trail.centre_m = CentreM(target);
    trail.epicenter_m = target.epicenter_m;
    trails_.push_back(trail);
  }
}

void Tracker::Follow(Trail& trail, base::TimeNs exposure_ns, const TargetPoints& points) const {
  if (trail.filter && exposure_ns <= trail.filter->ExposureNs()) trail.filter.reset();
  if (trail.filter) trail.filter->Advance(exposure_ns);
  if (trail.filter && exposure_ns - trail.measured_ns > motion_.coast_max_ns) trail.filter.reset();
  if (points.status == FixStatus::kLost) return;
  const BarPlace measured = MeasuredPlace(points).Moved(trail.centre_m - trail.epicenter_m);
  const auto chi_square = trail.filter ? trail.filter->ChiSquare(measured) : std::nullopt;
  trail.confirmed = chi_square && *chi_square <= motion_.chi_square_max;
  if (trail.confirmed)
    trail.filter->Update(measured);
  else
    trail.filter.emplace(motion_, exposure_ns, measured);
  trail.measured_ns = exposure_ns;
}

void Tracker::Track(const stereo::PointSet& points, TargetStateSet& out) {
  ADIT_REQUIRE(points.targets.size() == trails_.size());
  const base::TimeNs exposure_ns = points.stamp.mid_exposure_ns;
  out.targets.clear();
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    Trail& trail = trails_[i];
    if (exposure_ns != base::kNever) Follow(trail, exposure_ns, points.targets[i]);
    if (points.targets[i].status != FixStatus::kLost) trail.last_seen_ns = exposure_ns;
    out.targets.push_back({points.targets[i], exposure_ns, points.stamp.last_packet_ns, points.stamp.trigger,
                           trail.last_seen_ns});
  }
}

std::optional<BarFilter> Tracker::LockedAt(const Trail& trail, base::TimeNs exposure_ns) const {
  if (!trail.filter || !trail.confirmed || exposure_ns <= trail.filter->ExposureNs()) return std::nullopt;
  if (exposure_ns - trail.measured_ns > motion_.coast_max_ns) return std::nullopt;
  BarFilter filter = *trail.filter;
  filter.Advance(exposure_ns);
  const double variance_m2 = filter.Place().covariance.topLeftCorner<3, 3>().trace();
  if (!(variance_m2 <= motion_.sigma_max_m * motion_.sigma_max_m)) return std::nullopt;
  return filter;
}

void Tracker::Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const {
  out = {};
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    const auto filter = LockedAt(trails_[i], exposure_ns);
    if (!filter) continue;
    const BarPlace led1 = filter->Place().Moved(-trails_[i].centre_m);
    out[i] = {true, led1.point_b_m, led1.direction_b, led1.covariance};
  }
}

}  // namespace adit::track
