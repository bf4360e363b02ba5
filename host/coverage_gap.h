// Where the bars have not been, in words: the region to wave next.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/rig_uncertainty.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// A ninth of cam0's image between two distances from it, seen by both cameras, that the bars left out.
struct CoverageGap {
  int column = 0, row = 0;  ///< 0 to 2, from the left and from above
  double nearest_m = 0, farthest_m = 0;
  double depth_m = 0;        ///< one sigma of depth that the calibration leaves in its middle
  double noise_depth_m = 0;  ///< of one LED there, from its centroid's noise

  /// "lower left, 60 to 90 m".
  std::string Words() const;
};

/// Bars by a finished calibration: ideal pixels by its cameras, distances of their centres.
struct PlacedBars {
  std::span<const StereoBar> bars;
  std::span<const double> distances_m;
};

/// The ninths of cam0's image times 10 to 30, 30 to 60, 60 to 90 and 90 to 120 m whose middle both cameras
/// see and in which fewer than two bars' LEDs lie; first those where the calibration's part is the largest
/// against one LED's noise (`noise_px`): there a waved bar tells most.
std::vector<CoverageGap> CoverageGaps(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                      const PlacedBars& placed, double noise_px);

}  // namespace adit::host
