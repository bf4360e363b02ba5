// What a target looks like in the images: the ranges that the identification may accept (seed 4.3.4.2, model
// training).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/identify/model.h"
#include "firmware/identify/sighting_set.h"

namespace adit::host {

/// What the model must hold for.
struct TrainingOptions {
  double nearest_m = 5, farthest_m = 110;
  double tilt_max_rad = 1.05;  ///< 60 degrees towards or away from the camera; beyond, a bar is mostly depth
  double noise_px = 0.05;      ///< one standard deviation of a centroid's coordinate
  double focal_px = 3378;      ///< 25 mm over 7.4 um pixels
};

/// The ranges that centroid noise alone needs: those of 4.5 standard deviations (one LED set in 150 000 falls
/// outside) over all distances and tilts, propagated to first order through cross ratio and p2. Measured
/// ranges are never narrower. Off the image's centre lengths change by a few percent, which is included.
identify::Model NoiseRanges(const base::Target& target, const TrainingOptions& options);

/// A model from geometry alone: the noise ranges with half of their width added on either side, for what is
/// not noise (merging spots, dirt, distortion left over). `trained_on` says so.
identify::Model GeometryModel(const base::Target& target, const TrainingOptions& options);

/// One sighting's figures.
struct TrainingSample {
  double p2 = 0, collinearity = 0, length_px = 0;  ///< collinearity: rms distance from the line / length
};

/// What the recordings showed, image by image.
struct TrainingTally {
  std::size_t none = 0, one = 0, several = 0;  ///< images by their number of hits
  std::vector<TrainingSample> samples;         ///< of images with one hit
};

TrainingSample SampleOf(const identify::Sighting& sighting);

/// The noise ranges, widened to what was measured: the middle 99 % of the samples and a fifth of that width
/// on either side; lengths as measured with 10 % on either side. The tails are left out, because a lamp may
/// pass for the target now and then.
identify::Model RefinedModel(const identify::Model& noise, const TrainingTally& tally);

}  // namespace adit::host
