// TargetState -> GeoFix: from the rig frame into the site grid.
#pragma once

#include <optional>

#include "firmware/base/pose.h"
#include "firmware/georef/geo_fix.h"

namespace adit::georef {

/// The tie of the rig to the site grid, or none: then the site frame is the rig frame and every set says so.
class Georeference {
 public:
  Georeference() = default;
  explicit Georeference(const base::Pose<base::Site, base::Rig>& T_s_b) : T_s_b_(T_s_b) {}

  /// One thread; no allocation.
  void Apply(const track::TargetStateSet& states, GeoFixSet& out) const;

 private:
  std::optional<base::Pose<base::Site, base::Rig>> T_s_b_;
};

}  // namespace adit::georef
