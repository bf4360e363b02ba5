#include "host/replay.h"

#include <array>
#include <iomanip>
#include <memory>
#include <ostream>

#include "firmware/georef/absolute_orientation.h"
#include "firmware/optics/rig.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/track_row.h"
#include "host/model_list.h"
#include "host/pair_reader.h"
#include "host/progress.h"

namespace adit::host {
namespace {

/// The pipeline of the box over a recording, pair by pair.
class Replay {
 public:
  explicit Replay(pipeline::Pipeline pipeline)
      : pipeline_(std::move(pipeline)),
        blobs_(std::make_unique<std::array<detect::BlobSet, 2>>()),
        result_(std::make_unique<pipeline::PairResult>()) {
    track_.text = std::string(pipeline::TrackHeader()) + "\n";
    track_.positions.resize(pipeline_.Names().size());
    track_.targets = pipeline_.Names();
  }

  void Feed(const ImagePair& pair) {
    auto& [left, right] = *blobs_;
    pipeline_.Detect(pair.Frame(base::Side::kLeft), left);
    pipeline_.Detect(pair.Frame(base::Side::kRight), right);
    pipeline_.Locate(left, right, *result_);
    for (std::size_t i = 0; i < result_->fixes.targets.size(); ++i) {
      const pipeline::TrackRow row = pipeline::TrackRowOf(result_->fixes.targets[i], track_.targets[i]);
      track_.positions[i] += row.status == stereo::FixStatus::kLost ? 0 : 1;
      track_.text += pipeline::FormatTrackRow(row) + "\n";
    }
    ++track_.pairs;
  }

  ReplayedTrack TakeTrack() { return std::move(track_); }

 private:
  pipeline::Pipeline pipeline_;
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_;  // too large for a stack
  std::unique_ptr<pipeline::PairResult> result_;
  ReplayedTrack track_;
};

base::Result<pipeline::Pipeline> MakePipeline(const ReplayOrder& order, const optics::Rig& rig) {
  const auto models = LoadModels(order.models);
  if (!models) return models.error();
  pipeline::PipelineOptions options;
  options.tracker.filter = order.filter;
  auto bodies =
      track::LoadBodies(order.bodies, pipeline::TargetsOf(*models), identify::kMaxTargets - models->size());
  if (!bodies) return bodies.error();
  options.tracker.bodies = std::move(*bodies);
  if (!order.georeference.empty()) {
    const auto orientation = georef::LoadOrientation(order.georeference, rig.calibration_id);
    if (!orientation) return orientation.error();
    options.georeference = georef::Georeference(*orientation);
  }
  return pipeline::Pipeline::Make(rig, *models, options);
}

}  // namespace

void ReplayedTrack::PrintSummary(std::ostream& out) const {
  out << pairs << " pairs\n" << std::fixed << std::setprecision(2);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    out << targets[i] << ": " << positions[i] << " positions ("
        << 100.0 * static_cast<double>(positions[i]) / static_cast<double>(pairs) << " %)\n";
  }
}

base::Result<ReplayedTrack> ReplayRecording(const ReplayOrder& order) {
  const auto rig = optics::LoadRig(order.rig);
  if (!rig) return rig.error();
  auto pipeline = MakePipeline(order, *rig);
  if (!pipeline) return pipeline.error();
  auto reader = PairReader::Open(order.recording, ImageSize::Of(rig->left, order.rig),
                                 ImageSize::Of(rig->right, order.rig));
  if (!reader) return reader.error();
  Replay replay(std::move(*pipeline));
  Progress progress("track", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) return replay.TakeTrack();
    replay.Feed(**pair);
    progress.Step();
  }
}

}  // namespace adit::host
