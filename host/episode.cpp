#include "host/episode.h"

#include "firmware/base/require.h"

namespace adit::host {
namespace {

using base::Side;

pipeline::Pipeline ReadyPipeline(const sim::Scene& scene, const std::vector<identify::Model>& models) {
  pipeline::PipelineOptions options;
  options.detector.read_noise_dn = scene.sensor.read_noise_dn;
  options.detector.electrons_per_dn = scene.sensor.electrons_per_dn;
  auto pipeline = pipeline::Pipeline::Make(scene.rig, models, options);
  ADIT_REQUIRE(pipeline);
  return std::move(*pipeline);
}

}  // namespace

Episode::Episode(sim::Scene scene, const std::vector<identify::Model>& models, Imaging imaging)
    : world_(std::make_unique<sim::World>(std::move(scene))),
      pipeline_(ReadyPipeline(world_->GetScene(), models)),
      imaging_(imaging),
      centroids_(*world_),
      blobs_(std::make_unique<std::array<detect::BlobSet, 2>>()),
      result_(std::make_unique<pipeline::PairResult>()) {
  if (imaging != Imaging::kRendered) return;
  for (const Side side : {Side::kLeft, Side::kRight})
    cameras_[static_cast<std::size_t>(side)] = std::make_unique<SimulatedCamera>(*world_, side);
}

void Episode::Detect(Side side, std::uint64_t trigger, detect::BlobSet& blobs) {
  if (imaging_ == Imaging::kCentroids)
    centroids_.Expose(side, trigger, blobs);
  else
    pipeline_.Detect(cameras_[static_cast<std::size_t>(side)]->Expose(trigger), blobs);
}

const pipeline::PairResult& Episode::Expose(std::uint64_t trigger) {
  auto& [left, right] = *blobs_;
  Detect(Side::kLeft, trigger, left);
  Detect(Side::kRight, trigger, right);
  pipeline_.Locate(left, right, *result_);
  return *result_;
}

}  // namespace adit::host
