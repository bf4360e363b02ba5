#include "firmware/georef/georeference.h"

namespace adit::georef {

void Georeference::Apply(const track::TargetStateSet& states, GeoFixSet& out) const {
  const base::Pose<base::Site, base::Rig> pose = T_s_b_.value_or(base::Pose<base::Site, base::Rig>{});
  out.georeferenced = T_s_b_.has_value();
  out.targets.clear();
  for (const track::TargetState& state : states.targets) {
    GeoFix fix;
    fix.state = state;
    if (state.points.status != stereo::FixStatus::kLost) {
      fix.position_s_m = pose * state.points.epicenter_b_m;
      fix.covariance_s_m2 = pose.rotation * state.points.epicenter_covariance_m2 * pose.rotation.transpose();
      fix.direction_s = pose.rotation * state.points.direction_b;
      for (std::size_t i = 0; i < fix.leds_s_m.size(); ++i) fix.leds_s_m[i] = pose * state.points.leds_b_m[i];
    }
    out.targets.push_back(fix);
  }
}

}  // namespace adit::georef
