// TargetState -> GeoFix: from the rig frame into the site grid.
#pragma once

#include <optional>

#include "firmware/georef/absolute_orientation.h"
#include "firmware/georef/geo_fix.h"

namespace adit::georef {

/// The tie of the rig to the site grid, or none: then the site frame is the rig frame and every set says so.
class Georeference {
 public:
  Georeference() = default;
  explicit Georeference(const AbsoluteOrientation& orientation) : orientation_(orientation) {}

  /// Positions, LEDs and directions in the site frame; the covariance is that of the measurement and of the
  /// orientation together. One thread; no allocation.
  void Apply(const track::TargetStateSet& states, GeoFixSet& out) const;

 private:
  std::optional<AbsoluteOrientation> orientation_;
};

}  // namespace adit::georef
