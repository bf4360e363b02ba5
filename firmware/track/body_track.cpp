#include "firmware/track/body_track.h"

#include <algorithm>
#include <cmath>

namespace adit::track {

using stereo::FixStatus;
using stereo::LossReason;
using stereo::TargetPoints;

namespace {

/// Puts the pose into the words of a target.
void Fill(const BodyPose& pose, TargetPoints& points) {
  const Eigen::Matrix3d& rotation = pose.T_b_t.rotation;
  points.epicenter_b_m = pose.T_b_t.translation_m;
  points.epicenter_covariance_m2 = pose.covariance.topLeftCorner<3, 3>();
  points.direction_b = rotation.col(0);
  const Eigen::Matrix3d by_turn = -base::Skew(points.direction_b);
  points.direction_covariance = by_turn * pose.covariance.bottomRightCorner<3, 3>() * by_turn.transpose();
  points.epicenter_direction_covariance_m = pose.covariance.topRightCorner<3, 3>() * by_turn.transpose();
  points.leds_b_m.fill(points.epicenter_b_m);
  for (int axis = 0; axis < 3; ++axis)
    points.leds_b_m[static_cast<std::size_t>(axis) + 1] += rotation.col(axis);
  points.bar_m = (points.leds_b_m[3] - points.leds_b_m[0]).norm();
}

/// Whether a predicted pose is still worth telling.
bool KnowsItsWay(const BodyPose& pose, const MotionOptions& motion) {
  const double variance_m2 = pose.covariance.topLeftCorner<3, 3>().trace();
  return variance_m2 <= motion.sigma_max_m * motion.sigma_max_m &&
         pose.covariance.bottomRightCorner<3, 3>().trace() <= kTurnSigmaMaxRad * kTurnSigmaMaxRad;
}

}  // namespace

BodyTrack::BodyTrack(const Body& body, const std::vector<base::Target>& targets,
                     const BodyTrackOptions& options)
    : body_(body), options_(options) {
  for (std::size_t i = 0; i < body.bars.size(); ++i)
    epicenters_m_[i] = targets[body.bars[i].target].epicenter_m;
}

SeenBars BodyTrack::SeenIn(const stereo::PointSet& points, const TargetStateSet& states) const {
  SeenBars seen;
  for (std::size_t i = 0; i < body_.bars.size(); ++i) {
    const BodyBar& bar = body_.bars[i];
    const FixStatus status = states.targets[bar.target].points.status;
    if (status != FixStatus::kTracked && status != FixStatus::kRecovered) continue;
    seen[i] = MeasuredPlace(points.targets[bar.target]).Moved(bar.centre_m - epicenters_m_[i]);
  }
  return seen;
}

void BodyTrack::Follow(base::TimeNs exposure_ns, const SeenBars& seen,
                       const std::optional<BodyPose>& fitted) {
  if (filter_ &&
      (exposure_ns <= filter_->ExposureNs() || exposure_ns - measured_ns_ > options_.motion.coast_max_ns))
    filter_.reset();
  if (filter_) filter_->Advance(exposure_ns);
  for (std::size_t i = 0; i < body_.bars.size(); ++i) {
    if (!filter_ || !seen[i]) continue;
    if (filter_->Take(body_, body_.bars[i], *seen[i])) {
      confirmed_ = true;
      measured_ns_ = exposure_ns;
    } else {
      filter_.reset();  // the bars have their own say whether it jumped
    }
  }
  if (filter_ || !fitted) return;
  filter_.emplace(options_.motion, exposure_ns, body_, *fitted);
  confirmed_ = false;
  measured_ns_ = exposure_ns;
}

std::optional<BodyFilter> BodyTrack::LockedAt(base::TimeNs exposure_ns) const {
  if (!filter_ || !confirmed_ || last_seen_ns_ == base::kNever || exposure_ns < filter_->ExposureNs())
    return std::nullopt;
  if (exposure_ns - measured_ns_ > options_.motion.coast_max_ns) return std::nullopt;
  if (exposure_ns - last_seen_ns_ > options_.motion.one_bar_max_ns) return std::nullopt;
  BodyFilter filter = *filter_;
  filter.Advance(exposure_ns);
  return filter;
}

TargetPoints BodyTrack::Describe(const stereo::PointSet& points, const SeenBars& seen) const {
  TargetPoints described;
  described.target = static_cast<std::uint8_t>(options_.index);
  described.status = FixStatus::kTracked;
  described.reason = LossReason::kNone;
  double squared_px2 = 0;
  int count = 0;
  for (std::size_t i = 0; i < body_.bars.size(); ++i) {
    if (!seen[i]) continue;
    const TargetPoints& bar = points.targets[body_.bars[i].target];
    if (bar.status == FixStatus::kRecovered) described.status = FixStatus::kRecovered;
    described.recovered_mask |= bar.recovered_mask;
    squared_px2 += bar.reprojection_px * bar.reprojection_px;
    ++count;
  }
  if (count > 1) described.reprojection_px = std::sqrt(squared_px2 / count);
  return described;
}

TargetState BodyTrack::Track(const stereo::PointSet& points, const TargetStateSet& states) {
  TargetState state = states.targets[body_.bars[0].target];  // for the pair's times
  const LossReason of_bar = state.points.reason;
  const SeenBars seen = SeenIn(points, states);
  state.pose = FitBody(body_, seen);
  if (state.pose) last_seen_ns_ = state.mid_exposure_ns;
  if (state.mid_exposure_ns != base::kNever) Follow(state.mid_exposure_ns, seen, state.pose);
  state.points = Describe(points, seen);
  state.last_seen_ns = last_seen_ns_;
  const auto count = std::count_if(seen.begin(), seen.end(), [](const auto& bar) { return bar.has_value(); });
  if (!state.pose) {
    state.points = {};
    state.points.target = static_cast<std::uint8_t>(options_.index);
    state.points.reason = count == 0 ? of_bar : count == 1 ? LossReason::kOneBar : LossReason::kGeometry;
  }
  const auto locked = options_.filter ? LockedAt(state.mid_exposure_ns) : std::nullopt;
  if (locked && KnowsItsWay(locked->Pose(body_), options_.motion)) {
    if (!state.pose) state.points.status = FixStatus::kPredicted;
    state.pose = locked->Pose(body_);
  }
  if (state.pose) Fill(*state.pose, state.points);
  return state;
}

void BodyTrack::Expect(base::TimeNs exposure_ns, stereo::ExpectationSet& out) const {
  const auto filter = LockedAt(exposure_ns);
  if (!filter || exposure_ns == filter_->ExposureNs()) return;
  for (const BodyBar& bar : body_.bars) {
    const BarPlace led1 = filter->PlaceOf(body_, bar).Moved(-bar.centre_m);
    stereo::Expectation& known = out[bar.target];
    // The far end may swing where the near one hardly moves.
    const double variance_m2 = std::max(led1.covariance.topLeftCorner<3, 3>().trace(),
                                        led1.Moved(bar.length_m).covariance.topLeftCorner<3, 3>().trace());
    const double limit_m2 = known.known ? known.covariance.topLeftCorner<3, 3>().trace()
                                        : options_.motion.sigma_max_m * options_.motion.sigma_max_m;
    if (variance_m2 <= limit_m2)
      known = {true, false, led1.point_b_m, led1.direction_b, led1.covariance, known.flux_dn};
  }
}

}  // namespace adit::track
