#include "firmware/publish/epoch.h"

#include <cmath>

namespace adit::publish {
namespace {

// Copies position, sigmas and attitude into `epoch` if they can be told at all.
bool TakePosition(const georef::GeoFix& fix, const EpochRules& rules, Epoch& epoch) {
  const Eigen::Matrix3d& covariance = fix.covariance_s_m2;
  const double horizontal_m = std::sqrt(covariance(0, 0) + covariance(1, 1));
  const double vertical_m = std::sqrt(covariance(2, 2));
  const Eigen::Vector3d origin_s_m(rules.origin_s_m[0], rules.origin_s_m[1], rules.origin_s_m[2]);
  const bool finite = std::isfinite(horizontal_m) && std::isfinite(vertical_m);
  if (!finite || !FitsTheWire(fix.position_s_m - origin_s_m)) return false;
  epoch.position_s_m = {fix.position_s_m.x(), fix.position_s_m.y(), fix.position_s_m.z()};
  epoch.sigma_horizontal_m = horizontal_m;
  epoch.sigma_vertical_m = vertical_m;
  if (fix.attitude) {
    epoch.heading_rad = fix.attitude->heading_rad;
    epoch.pitch_rad = fix.attitude->pitch_rad;
    epoch.roll_rad = fix.attitude->roll_rad;
  }
  epoch.sigma_ok = horizontal_m <= rules.sigma_limit_m && vertical_m <= rules.sigma_limit_m;
  return true;
}

BoxState JudgeState(const Epoch& epoch, const BoxCondition& box, bool seen_before) {
  if (box.simulation) return BoxState::kSimulation;
  if ((box.faults & kFaultsThatStop) != 0) return BoxState::kFault;
  if (box.service) return BoxState::kService;
  if (!box.initialised) return BoxState::kInit;
  switch (epoch.validity) {
    case Validity::kValid:
      return BoxState::kTrack;
    case Validity::kDegraded:
      return BoxState::kDegraded;
    case Validity::kInvalid:
    case Validity::kSimulated:
      break;
  }
  return seen_before ? BoxState::kLost : BoxState::kSearch;
}

// Of an epoch that has a position.
Validity JudgeValidity(const georef::GeoFix& fix, const Epoch& epoch, const BoxCondition& box) {
  if (box.simulation) return Validity::kSimulated;
  // 2026-11-26: a recovered place is told, but no machine steers by it. Of 194 400 target-frames among lamps
  // collinear with LEDs (the scenes of evaluate --suite underground, swaps) 31 were wrong: lamps taken for
  // LEDs, and LEDs that had merged with a lamp. VALID once none is, and its sigmas hold as they do for four
  // LEDs.
  const bool whole = fix.state.points.status == stereo::FixStatus::kTracked;
  const bool sound = !box.service && (box.faults & kFaultsThatDegrade) == 0;
  return whole && epoch.sigma_ok && sound ? Validity::kValid : Validity::kDegraded;
}

void DropValues(Epoch& epoch) {
  epoch.validity = Validity::kInvalid;
  epoch.sigma_ok = false;
  epoch.position_s_m.reset();
  epoch.sigma_horizontal_m.reset();
  epoch.sigma_vertical_m.reset();
  epoch.heading_rad.reset();
  epoch.pitch_rad.reset();
  epoch.roll_rad.reset();
}

bool IsFresh(const Epoch& epoch, base::TimeNs now_ns) {
  const std::optional<base::DurationNs> age_ns = AgeAt(epoch, now_ns);
  return age_ns && *age_ns <= epoch.age_limit_ns;
}

// Whether a position of this fix could be told if its numbers are right.
bool MayHavePosition(const georef::GeoFix& fix, const BoxCondition& box, const EpochRules& rules) {
  if ((box.faults & kFaultsThatStop) != 0) return false;
  if (!box.georeferenced && rules.origin_s_m != std::array<std::int32_t, 3>{}) return false;
  return fix.state.points.status != stereo::FixStatus::kLost;
}

}  // namespace

bool FitsTheWire(const Eigen::Vector3d& offset_s_m) {
  return (offset_s_m.array().abs() <= kOffsetMaxM).all();  // a NaN does not fit
}

std::optional<base::DurationNs> AgeAt(const Epoch& epoch, base::TimeNs now_ns) {
  // Also keeps the difference below from overflowing: kNever is the smallest time there is.
  if (epoch.mid_exposure_ns == base::kNever || now_ns == base::kNever) return std::nullopt;
  const base::DurationNs age_ns = now_ns - epoch.mid_exposure_ns;
  if (age_ns < -kClockSlackNs) return std::nullopt;
  return age_ns < 0 ? 0 : age_ns;
}

Epoch MakeEpoch(const georef::GeoFix* fix, const BoxCondition& box, const EpochRules& rules,
                base::TimeNs now_ns) {
  Epoch epoch;
  epoch.number = box.epoch;
  epoch.faults = box.faults;
  epoch.alive = box.alive;
  epoch.targets_seen = box.targets_seen;
  epoch.targets_used = box.targets_used;
  epoch.heartbeat = box.heartbeat;
  epoch.clock = box.clock;
  epoch.georeferenced = box.georeferenced;
  epoch.age_limit_ns = rules.age_limit_ns;
  epoch.origin_s_m = rules.origin_s_m;
  if (!box.georeferenced) epoch.faults |= kFaultGeoreference;
  if (fix != nullptr) {
    epoch.mid_exposure_ns = fix->state.mid_exposure_ns;
    if (MayHavePosition(*fix, box, rules) && IsFresh(epoch, now_ns) && TakePosition(*fix, rules, epoch)) {
      epoch.validity = JudgeValidity(*fix, epoch, box);
    }
  }
  const bool seen_before = fix != nullptr && fix->state.last_seen_ns != base::kNever;
  epoch.state = JudgeState(epoch, box, seen_before);
  return epoch;
}

Epoch AsOf(const Epoch& epoch, base::TimeNs now_ns) {
  Epoch current = epoch;
  if (current.validity == Validity::kInvalid || IsFresh(current, now_ns)) return current;
  DropValues(current);
  if (current.state == BoxState::kTrack || current.state == BoxState::kDegraded) {
    current.state = BoxState::kLost;
  }
  return current;
}

}  // namespace adit::publish
