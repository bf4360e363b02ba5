// A short piece of a simulated world through the pipeline of the box, pair by pair in time order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/sim/world.h"
#include "firmware/pipeline/pipeline.h"
#include "host/simulated_blobs.h"
#include "host/simulated_camera.h"

namespace adit::host {

/// Where the blobs come from.
enum class Imaging : std::uint8_t {
  kCentroids,  ///< simulated
  kRendered,   ///< detected by the box's own detection in rendered images
};

/// Every tenth piece of a large count is rendered.
inline Imaging ImagingOf(std::size_t index) {
  return index % 10 == 0 ? Imaging::kRendered : Imaging::kCentroids;
}

/// One episode: a world, the models that are sought in it, and a pipeline that starts without any lock.
class Episode {
 public:
  /// Ends the program if the models are refused: a mistake of the campaign.
  Episode(sim::Scene scene, const std::vector<identify::Model>& models, Imaging imaging);

  const sim::World& GetWorld() const { return *world_; }
  SimulatedBlobs& Centroids() { return centroids_; }
  Imaging GetImaging() const { return imaging_; }

  /// The pair of this trigger; call in ascending order. Valid until the next call.
  const pipeline::PairResult& Expose(std::uint64_t trigger);

 private:
  void Detect(base::Side side, std::uint64_t trigger, detect::BlobSet& blobs);

  std::unique_ptr<sim::World> world_;
  pipeline::Pipeline pipeline_;
  Imaging imaging_;
  SimulatedBlobs centroids_;
  std::array<std::unique_ptr<SimulatedCamera>, 2> cameras_;  // when rendered
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_;    // too large for a stack
  std::unique_ptr<pipeline::PairResult> result_;
};

}  // namespace adit::host
