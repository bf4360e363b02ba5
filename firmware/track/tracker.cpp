#include "firmware/track/tracker.h"

namespace adit::track {

void Tracker::Track(const stereo::PointSet& points, TargetStateSet& out) {
  out.targets.clear();
  while (last_seen_ns_.size() < points.targets.size()) last_seen_ns_.push_back(base::kNever);
  for (std::size_t i = 0; i < points.targets.size(); ++i) {
    if (points.targets[i].status != stereo::FixStatus::kLost) last_seen_ns_[i] = points.stamp.mid_exposure_ns;
    out.targets.push_back({points.targets[i], points.stamp.mid_exposure_ns, points.stamp.last_packet_ns,
                           points.stamp.trigger, last_seen_ns_[i]});
  }
}

}  // namespace adit::track
