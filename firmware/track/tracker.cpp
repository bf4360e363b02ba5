#include "firmware/track/tracker.h"

#include <cmath>

namespace adit::track {

using stereo::FixStatus;
using stereo::TargetPoints;

namespace {

/// Puts `epicenter` in the place of what was measured.
void Fill(const BarPlace& epicenter, TargetPoints& points) {
  points.epicenter_b_m = epicenter.point_b_m;
  points.direction_b = epicenter.direction_b;
  points.epicenter_covariance_m2 = epicenter.covariance.topLeftCorner<3, 3>();
  points.direction_covariance = epicenter.covariance.bottomRightCorner<3, 3>();
  points.epicenter_direction_covariance_m = epicenter.covariance.topRightCorner<3, 3>();
}

TargetPoints Lost(const TargetPoints& points, stereo::LossReason reason) {
  TargetPoints lost;
  lost.target = points.target;
  lost.reason = reason;
  return lost;
}

}  // namespace

Tracker::Tracker(const std::vector<base::Target>& targets, const TrackerOptions& options)
    : options_(options), targets_(targets) {
  ADIT_REQUIRE(targets.size() + options.bodies.size() <= identify::kMaxTargets);
  for (const base::Target& target : targets) {
    Trail trail;
    trail.centre_m = CentreM(target);
    trail.epicenter_m = target.epicenter_m;
    trails_.push_back(trail);
  }
  for (const Body& body : options.bodies) {
    const BodyTrackOptions chosen{options.motion, options.filter, targets.size() + bodies_.size()};
    bodies_.emplace_back(body, targets, chosen);
  }
}

void Tracker::Advance(Trail& trail, base::TimeNs exposure_ns) const {
  const MotionOptions& motion = options_.motion;
  if (trail.rival && (exposure_ns <= trail.rival->ExposureNs() ||
                      exposure_ns - trail.rival->ExposureNs() > motion.confirm_max_ns))
    trail.rival.reset();
  if (trail.filter &&
      (exposure_ns <= trail.filter->ExposureNs() || exposure_ns - trail.measured_ns > motion.coast_max_ns))
    trail.filter.reset();
  if (trail.rival) trail.rival->Advance(exposure_ns);
  if (trail.filter) trail.filter->Advance(exposure_ns);
}

bool Tracker::Fits(const std::optional<BarFilter>& filter, const BarPlace& measured) const {
  const auto chi_square = filter ? filter->ChiSquare(measured) : std::nullopt;
  return chi_square && *chi_square <= options_.motion.chi_square_max;
}

/// Whether the measurement is believed.
bool Tracker::Take(Trail& trail, base::TimeNs exposure_ns, const BarPlace& measured) const {
  const bool fits = Fits(trail.filter, measured);
  const bool locked = trail.filter && IsLocked(trail, *trail.filter);
  const bool fits_rival = Fits(trail.rival, measured);
  if (!fits && locked && !fits_rival) {
    trail.rival.emplace(options_.motion, exposure_ns, measured);
    return false;
  }
  if (!fits) trail.flux_ns = base::kNever;
  if (!fits && fits_rival) trail.filter = trail.rival;
  if (fits || fits_rival)
    trail.filter->Update(measured);
  else
    trail.filter.emplace(options_.motion, exposure_ns, measured);
  trail.confirmed = fits || fits_rival;
  trail.rival.reset();
  trail.measured_ns = exposure_ns;
  return true;
}

/// How bright the LEDs are, of a measurement that is believed.
void Tracker::TakeFlux(Trail& trail, const TargetPoints& measured) const {
  // A machine that turns shows its LEDs at other angles of their beams; in a second it turns by little.
  constexpr base::DurationNs kOldNs = base::kNsPerS;
  const bool whole = measured.status == FixStatus::kTracked;
  const bool old = trail.flux_ns == base::kNever || (whole && trail.measured_ns - trail.flux_ns > kOldNs);
  if (old) trail.flux_dn = {}, trail.flux_ns = trail.measured_ns;
  // What is known stays: a lamp that comes nearer makes an LED brighter little by little.
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      float& known_dn = trail.flux_dn[side][i];
      if (!(known_dn > 0)) known_dn = measured.flux_dn[side][i];
    }
  }
}

/// The state's points: measured, filtered, predicted or lost.
TargetPoints Tracker::Judge(Trail& trail, base::TimeNs exposure_ns, const TargetPoints& measured) const {
  Advance(trail, exposure_ns);
  TargetPoints judged = measured;
  const double to_epicenter_m = trail.epicenter_m - trail.centre_m;
  if (judged.status != FixStatus::kLost) {
    const bool taken = Take(trail, exposure_ns, MeasuredPlace(measured).Moved(-to_epicenter_m));
    if (taken) TakeFlux(trail, measured);
    // Of a target that was seen before three LEDs may be what its reflection shows, for a pair.
    const bool doubted =
        measured.status == FixStatus::kRecovered && !trail.confirmed && trail.last_seen_ns != base::kNever;
    if (!taken || doubted) judged = Lost(measured, stereo::LossReason::kJump);
  }
  if (!options_.filter) return judged;
  if (judged.status == FixStatus::kLost) {
    const auto bridge = LockedAt(trail, exposure_ns);
    if (!bridge) return judged;
    const base::Target& target = targets_[measured.target];
    judged.status = FixStatus::kPredicted;
    judged.bar_m = target.LengthM();
    for (std::size_t i = 0; i < judged.leds_b_m.size(); ++i)
      judged.leds_b_m[i] = bridge->Place().Moved(target.leds_m[i] - trail.centre_m).point_b_m;
  }
  Fill(trail.filter->Place().Moved(to_epicenter_m), judged);
  return judged;
}

void Tracker::Track(const stereo::PointSet& points, TargetStateSet& out) {
  ADIT_REQUIRE(points.targets.size() == trails_.size());
  const base::TimeNs exposure_ns = points.stamp.mid_exposure_ns;
  out.targets.clear();
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    Trail& trail = trails_[i];
    TargetState state;
    state.points = points.targets[i];
    state.mid_exposure_ns = exposure_ns;
    state.last_packet_ns = points.stamp.last_packet_ns;
    state.trigger = points.stamp.trigger;
    if (exposure_ns != base::kNever) state.points = Judge(trail, exposure_ns, points.targets[i]);
    const FixStatus status = state.points.status;
    if (status == FixStatus::kTracked || status == FixStatus::kRecovered) trail.last_seen_ns = exposure_ns;
    state.last_seen_ns = trail.last_seen_ns;
    out.targets.push_back(state);
  }
  for (BodyTrack& body : bodies_) out.targets.push_back(body.Track(points, out));
}

/// Whether the target of the trail is locked when its filter has come to `filter`.
bool Tracker::IsLocked(const Trail& trail, const BarFilter& filter) const {
  const MotionOptions& motion = options_.motion;
  return trail.confirmed && filter.ExposureNs() - trail.measured_ns <= motion.coast_max_ns &&
         filter.PointVarianceM2() <= motion.sigma_max_m * motion.sigma_max_m;
}

/// The filter at that time, if its target is locked then.
std::optional<BarFilter> Tracker::LockedAt(const Trail& trail, base::TimeNs exposure_ns) const {
  if (!trail.filter || exposure_ns < trail.filter->ExposureNs()) return std::nullopt;
  BarFilter filter = *trail.filter;
  filter.Advance(exposure_ns);
  if (!IsLocked(trail, filter)) return std::nullopt;
  return filter;
}

void Tracker::Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const {
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    const Trail& trail = trails_[i];
    out[i] = {};
    const bool is_later = trail.filter && exposure_ns > trail.filter->ExposureNs();
    if (!is_later || exposure_ns - trail.measured_ns > options_.motion.coast_max_ns) continue;
    BarFilter filter = *trail.filter;
    filter.Advance(exposure_ns);
    const bool locked = IsLocked(trail, filter);
    const BarPlace led1 = filter.Place().Moved(-trail.centre_m);
    out[i] = {locked, !locked, led1.point_b_m, led1.direction_b, led1.covariance, trail.flux_dn};
  }
  for (const BodyTrack& body : bodies_) body.Expect(exposure_ns, out);
}

std::optional<BarPlace> Tracker::PlaceAt(std::size_t target, base::TimeNs time_ns) const {
  const Trail& trail = trails_[target];
  const auto filter = LockedAt(trail, time_ns);
  if (!filter) return std::nullopt;
  return filter->Place().Moved(trail.epicenter_m - trail.centre_m);
}

}  // namespace adit::track
