// Whether the image of one line target can pass for another.
#pragma once

#include <optional>

#include "firmware/base/target.h"

namespace adit::host {

/// How the targets are seen.
struct ViewConditions {
  double tilt_max_rad = 1.05;  ///< how far a bar leans towards or away from the camera
  double focal_px = 3378;
  double noise_px = 0.05;  ///< one standard deviation of a centroid's coordinate
};

/// How far the image of `seen` is from any image that `taken_for` can make, in standard deviations of the
/// centroids: the least-squares distance of the four places along the image line over place, length,
/// direction and lean (up to tilt_max) of `taken_for`; the smallest over leans of `seen`. Lengths in metres
/// are not compared: one image does not tell the distance. With `taken_for` == `seen` it is how well the
/// direction can be told. Scales with 1 / noise.
double SeparationSigmas(const base::Target& seen, const base::Target& taken_for, double distance_m,
                        const ViewConditions& conditions);
/// The same with the bar read from its own other end only.
double DirectionSigmas(const base::Target& target, double distance_m, const ViewConditions& conditions);

/// What a separation must exceed so that no confusion is left: what the identification accepts (its sigmas,
/// with its floor), and 4.5 sigmas by which the noise may move the image.
double NeededSigmas(double noise_px);

/// The farthest distance up to which neither passes for the other, within [nearest, farthest]; none if they
/// can be confused at the nearest already.
std::optional<double> DistinctUpToM(const base::Target& a, const base::Target& b, double nearest_m,
                                    double farthest_m, const ViewConditions& conditions);

}  // namespace adit::host
