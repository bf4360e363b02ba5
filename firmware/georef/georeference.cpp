#include "firmware/georef/georeference.h"

namespace adit::georef {
namespace {

void PutOnGrid(const AbsoluteOrientation& orientation, const track::TargetState& state, GeoFix& fix) {
  const stereo::TargetPoints& points = state.points;
  fix.position_s_m = orientation.Apply(points.epicenter_b_m);
  fix.covariance_s_m2 = orientation.Propagate(points.epicenter_b_m, points.epicenter_covariance_m2);
  fix.direction_s = orientation.Turn(points.direction_b);
  for (std::size_t i = 0; i < fix.leds_s_m.size(); ++i)
    fix.leds_s_m[i] = orientation.Apply(points.leds_b_m[i]);
  if (!state.pose) return;
  Eigen::Matrix3d R_s_t;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    R_s_t.col(axis) = orientation.Turn(state.pose->T_b_t.rotation.col(axis));
  fix.attitude = AttitudeOf(R_s_t);
}

/// As measured, to the last bit.
void LeaveInRigFrame(const stereo::TargetPoints& points, GeoFix& fix) {
  fix.position_s_m = points.epicenter_b_m;
  fix.covariance_s_m2 = points.epicenter_covariance_m2;
  fix.direction_s = points.direction_b;
  fix.leds_s_m = points.leds_b_m;
}

}  // namespace

void Georeference::Apply(const track::TargetStateSet& states, GeoFixSet& out) const {
  out.georeferenced = orientation_.has_value();
  out.targets.clear();
  for (const track::TargetState& state : states.targets) {
    GeoFix fix;
    fix.state = state;
    const bool has_place = state.points.status != stereo::FixStatus::kLost;
    if (has_place && orientation_) PutOnGrid(*orientation_, state, fix);
    if (has_place && !orientation_) LeaveInRigFrame(state.points, fix);
    out.targets.push_back(fix);
  }
}

}  // namespace adit::georef
