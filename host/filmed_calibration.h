// A simulated calibration as a recording would have it: the bars in a world with lights, seen by the
// detection.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/sim/scene.h"
#include "host/episode.h"
#include "host/simulated_calibration.h"

namespace adit::host {

/// The draw's bars as a scene: each frame another place of the bar, which stands while it is exposed. The
/// brightest LED peaks at 200 DN. `seed` is that of the images' noise.
sim::Scene SceneOf(const CalibrationPlan& plan, const CalibrationDraw& draw, std::uint64_t seed);

/// 14 lamps, 3 machines with headlights that come nearer, and in every fifth frame a plate before an LED of
/// the bar, which hides half of it or more from one camera.
void AddClutter(const CalibrationDraw& draw, std::uint64_t seed, sim::Scene& scene);

/// The candidate bars that `adit calibrate` finds in the scene, by the camera files of `input`. With
/// `kCentroids` every centroid has the noise `noise_px`, and the cameras must be as their files say.
std::vector<StereoBar> FindBars(const sim::Scene& scene, const CalibrationInput& input, Imaging imaging,
                                double noise_px);

}  // namespace adit::host
