// What the georeference hands on: targets in the site grid, ready to be published.
#pragma once

#include <array>
#include <optional>

#include "firmware/base/pose.h"
#include "firmware/georef/attitude.h"
#include "firmware/track/target_state.h"

namespace adit::georef {

/// One target or body in the site frame s (easting, northing, height; metres). Without a georeference the
/// site frame is the rig frame, and GeoFixSet says so.
struct GeoFix {
  track::TargetState state;
  Eigen::Vector3d position_s_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_s_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d direction_s = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, base::kLedCount> leds_s_m =
      base::ZeroPoints<base::kLedCount>();  ///< each LED on its own
  /// Of a body, and only on the site grid: the rig frame knows neither north nor up.
  std::optional<Attitude> attitude;
};

struct GeoFixSet {
  base::FixedVector<GeoFix, identify::kMaxTargets> targets;
  bool georeferenced = false;
};

}  // namespace adit::georef
