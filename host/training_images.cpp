#include "host/training_images.h"

#include <algorithm>
#include <memory>

#include "firmware/detect/detector.h"
#include "firmware/identify/identifier.h"
#include "firmware/optics/rig.h"
#include "host/pair_reader.h"
#include "host/progress.h"

namespace adit::host {
namespace {

constexpr double kLooseSigmas = 16;  // four times the box's: an LED half hidden, smeared or merged

identify::Model Unbounded(identify::Model model) {
  model.p2_min = 2.0, model.p2_max = 2.8;
  model.collinearity_max = 1;
  model.length_min_px *= 0.5, model.length_max_px *= 1.3;
  return model;
}

/// One camera's search.
class ImageSearch {
 public:
  ImageSearch(const optics::CameraModel& camera, const identify::Model& model)
      : detector_(camera, {}), strict_(Make(camera, model, {})), loose_(Make(camera, model, Loose())) {}

  void Search(const base::CameraFrame& frame, TrainingImage& image) {
    detector_.Detect(frame, {}, *blobs_);
    image.blobs = blobs_->blobs.size();
    Append(strict_, true, image);
    if (image.hits.empty()) Append(loose_, false, image);
  }

 private:
  static identify::IdentifierOptions Loose() {
    identify::IdentifierOptions options;
    options.sigmas = kLooseSigmas;
    return options;
  }
  static identify::Identifier Make(const optics::CameraModel& camera, const identify::Model& model,
                                   identify::IdentifierOptions options) {
    options.focal_px = camera.fu_px;
    return identify::Identifier({Unbounded(model)}, options);
  }

  /// Sightings of the same four blobs (a layout that reads from both ends) are one hit.
  void Append(identify::Identifier& identifier, bool within_noise, TrainingImage& image) {
    identifier.Identify(*blobs_, sightings_);
    std::vector<std::array<std::uint16_t, base::kLedCount>> known;
    for (const identify::Sighting& sighting : sightings_.sightings) {
      auto blobs = sighting.blobs;
      std::sort(blobs.begin(), blobs.end());
      if (std::find(known.begin(), known.end(), blobs) != known.end()) continue;
      known.push_back(blobs);
      TrainingHit hit;
      hit.figures = SampleOf(sighting);
      hit.within_noise = within_noise;
      for (std::size_t i = 0; i < hit.leds_px.size(); ++i)
        hit.leds_px[i] = blobs_->blobs[sighting.blobs[i]].raw_px;
      image.hits.push_back(hit);
    }
  }

  detect::Detector detector_;
  identify::Identifier strict_, loose_;
  std::unique_ptr<detect::BlobSet> blobs_ = std::make_unique<detect::BlobSet>();  // too large for a stack
  identify::SightingSet sightings_;
};

}  // namespace

base::Result<void> SearchRecording(const TrainingRecording& recording, std::size_t index,
                                   const identify::Model& model, std::vector<TrainingImage>& images) {
  std::array<optics::CameraModel, 2> cameras;
  std::array<std::string, 2> files;
  for (std::size_t i = 0; i < 2; ++i) {
    files[i] = recording.camera.empty() ? recording.folder + "/cam" + std::to_string(i) + "/sensor.yaml"
                                        : recording.camera;
    const auto camera = optics::LoadCamera(files[i]);
    if (!camera) return camera.error();
    cameras[i] = *camera;
  }
  auto reader = PairReader::Open(recording.folder, ImageSize::Of(cameras[0], files[0]),
                                 ImageSize::Of(cameras[1], files[1]));
  if (!reader) return reader.error();
  std::array<ImageSearch, 2> searches{ImageSearch(cameras[0], model), ImageSearch(cameras[1], model)};
  Progress progress("train", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) return {};
    for (const base::Side side : {base::Side::kLeft, base::Side::kRight}) {
      TrainingImage image{index, side, (*pair)->mid_exposure_ns, 0, {}};
      searches[static_cast<std::size_t>(side)].Search((*pair)->Frame(side), image);
      images.push_back(std::move(image));
    }
    progress.Step();
  }
}

bool Passes(const identify::Model& model, const TrainingHit& hit) {
  const TrainingSample& figures = hit.figures;
  return hit.within_noise && figures.p2 >= model.p2_min && figures.p2 <= model.p2_max &&
         figures.collinearity <= model.collinearity_max && figures.length_px >= model.length_min_px &&
         figures.length_px <= model.length_max_px;
}

TrainingTally TallyOf(const identify::Model& model, const std::vector<TrainingImage>& images) {
  TrainingTally tally;
  for (const TrainingImage& image : images) {
    const TrainingHit* last = nullptr;
    std::size_t passing = 0;
    for (const TrainingHit& hit : image.hits) {
      if (!Passes(model, hit)) continue;
      last = &hit;
      ++passing;
    }
    ++(passing == 0 ? tally.none : passing == 1 ? tally.one : tally.several);
    if (passing == 1) tally.samples.push_back(last->figures);
  }
  return tally;
}

}  // namespace adit::host
