// What the images of a recording show that could be the target, whatever the trained ranges say: so that
// every range can be judged afterwards without reading the images again.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/base/result.h"
#include "firmware/identify/model.h"
#include "host/training.h"

namespace adit::host {

/// Four blobs that could be the target.
struct TrainingHit {
  TrainingSample figures;
  std::array<Eigen::Vector2d, base::kLedCount> leds_px{};  ///< raw pixels, LED 1 to LED 4
  /// Order, line and cross ratio fit within the noise that the centroids state: what a box asks besides the
  /// trained ranges. Hits beyond it (to 16 sigmas) are kept of images that show none within.
  bool within_noise = true;
};

/// One image of one camera.
struct TrainingImage {
  std::size_t recording = 0;  ///< index into the recordings given
  base::Side side = base::Side::kLeft;
  base::TimeNs mid_exposure_ns = 0;
  std::size_t blobs = 0;
  std::vector<TrainingHit> hits;
};

/// Where the images are.
struct TrainingRecording {
  std::string folder;
  std::string camera;  ///< sensor.yaml of both cameras; empty: the recording's own
};

/// Searches every image for `target` with p2 and collinearity free, and lengths from half of to 1.3 times
/// those of `model`. Appends to `images`, pair by pair, left before right. Declines as PairReader does.
base::Result<void> SearchRecording(const TrainingRecording& recording, std::size_t index,
                                   const identify::Model& model, std::vector<TrainingImage>& images);

/// Whether a box with this model would report the hit.
bool Passes(const identify::Model& model, const TrainingHit& hit);

/// The tally that `model` makes of the images (RefinedModel's input).
TrainingTally TallyOf(const identify::Model& model, const std::vector<TrainingImage>& images);

}  // namespace adit::host
