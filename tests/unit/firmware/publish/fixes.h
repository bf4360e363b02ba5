// Fixes and boxes to publish, all well unless the test says otherwise.
#pragma once

#include "firmware/publish/epoch.h"

namespace adit::publish {

inline constexpr base::TimeNs kExposureNs = 1'700'000'000'123'456'789;

/// A tracked target at (10.1, 20.2, -3.3) m, sigmas 3 and 4 mm (horizontal: 5 mm) and 2 mm.
inline georef::GeoFix TrackedFix() {
  georef::GeoFix fix;
  fix.state.points.status = stereo::FixStatus::kTracked;
  fix.state.points.reprojection_px = 0.12;
  fix.state.mid_exposure_ns = kExposureNs;
  fix.state.last_seen_ns = kExposureNs;
  fix.position_s_m = Eigen::Vector3d(10.1, 20.2, -3.3);
  fix.covariance_s_m2 = Eigen::Vector3d(9e-6, 16e-6, 4e-6).asDiagonal();
  return fix;
}

inline BoxCondition GoodBox() {
  BoxCondition box;
  box.epoch = 0x1234;
  box.alive = 77;
  box.heartbeat = 4321;
  box.initialised = true;
  box.georeferenced = true;
  box.targets_seen = 2;
  box.targets_used = 1;
  box.clock = ClockSource::kPtp;
  return box;
}

}  // namespace adit::publish
