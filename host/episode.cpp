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
  for (const Side side : {Side::kLeft, Side::kRight}) {
    auto& renderer = renderers_[static_cast<std::size_t>(side)];
    renderer = std::make_unique<sim::Renderer>(*world_, side, sim::NoiseSource::kFresh);
    pixels_.resize(renderer->FrameBytes());
  }
}

void Episode::Detect(Side side, std::uint64_t trigger, detect::BlobSet& blobs) {
  if (imaging_ == Imaging::kCentroids) {
    centroids_.Expose(side, trigger, blobs);
    return;
  }
  renderers_[static_cast<std::size_t>(side)]->Render(trigger, pixels_.data());
  const optics::CameraModel& camera = world_->Camera(side);
  base::CameraFrame frame;
  frame.stamp.mid_exposure_ns = world_->MidExposureNs(trigger);
  frame.stamp.last_packet_ns = frame.stamp.mid_exposure_ns + 12 * base::kNsPerMs;  // 1.4 MB at 1 Gbit/s
  frame.stamp.trigger = trigger;
  frame.stamp.side = side;
  frame.image.data = pixels_.data();
  frame.image.width_px = camera.width_px;
  frame.image.height_px = camera.height_px;
  frame.image.bits = world_->GetScene().sensor.bits;
  frame.image.stride_bytes = static_cast<std::ptrdiff_t>(camera.width_px) * frame.image.BytesPerPixel();
  pipeline_.Detect(frame, blobs);
}

const pipeline::PairResult& Episode::Expose(std::uint64_t trigger) {
  auto& [left, right] = *blobs_;
  Detect(Side::kLeft, trigger, left);
  Detect(Side::kRight, trigger, right);
  pipeline_.Locate(left, right, *result_);
  return *result_;
}

}  // namespace adit::host
