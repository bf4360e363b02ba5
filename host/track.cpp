#include "host/track.h"

#include <CLI/CLI.hpp>
#include <array>
#include <iomanip>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/optics/rig.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/track_row.h"
#include "host/failure.h"
#include "host/model_list.h"
#include "host/pair_reader.h"
#include "host/progress.h"

namespace adit::host {
namespace {

struct TrackArguments {
  std::string recording, rig, out;
  std::vector<std::string> models;
};

/// The pipeline of the box over a recording, pair by pair, and the track file that it makes.
class Replay {
 public:
  explicit Replay(pipeline::Pipeline pipeline)
      : pipeline_(std::move(pipeline)),
        blobs_(std::make_unique<std::array<detect::BlobSet, 2>>()),
        result_(std::make_unique<pipeline::PairResult>()),
        positions_(pipeline_.Models().size(), 0),
        text_(std::string(pipeline::TrackHeader()) + "\n") {}

  void Feed(const ImagePair& pair) {
    auto& [left, right] = *blobs_;
    pipeline_.Detect(pair.Frame(base::Side::kLeft), left);
    pipeline_.Detect(pair.Frame(base::Side::kRight), right);
    pipeline_.Locate(left, right, *result_);
    for (std::size_t i = 0; i < result_->fixes.targets.size(); ++i) {
      const pipeline::TrackRow row =
          pipeline::TrackRowOf(result_->fixes.targets[i], pipeline_.Models()[i].target.name);
      positions_[i] += row.status == stereo::FixStatus::kLost ? 0 : 1;
      text_ += pipeline::FormatTrackRow(row) + "\n";
    }
    ++pairs_;
  }

  const std::string& Text() const { return text_; }

  void PrintSummary(std::ostream& out) const {
    out << pairs_ << " pairs\n" << std::fixed << std::setprecision(2);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      out << pipeline_.Models()[i].target.name << ": " << positions_[i] << " positions ("
          << 100.0 * static_cast<double>(positions_[i]) / static_cast<double>(pairs_) << " %)\n";
    }
  }

 private:
  pipeline::Pipeline pipeline_;
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_;  // too large for a stack
  std::unique_ptr<pipeline::PairResult> result_;
  std::vector<std::size_t> positions_;
  std::size_t pairs_ = 0;
  std::string text_;
};

base::Result<Replay> Replayed(const TrackArguments& arguments) {
  const auto rig = optics::LoadRig(arguments.rig);
  if (!rig) return rig.error();
  const auto models = LoadModels(arguments.models);
  if (!models) return models.error();
  auto pipeline = pipeline::Pipeline::Make(*rig, *models, {});
  if (!pipeline) return pipeline.error();
  auto reader = PairReader::Open(arguments.recording, ImageSize::Of(rig->left, arguments.rig),
                                 ImageSize::Of(rig->right, arguments.rig));
  if (!reader) return reader.error();
  Replay replay(std::move(*pipeline));
  Progress progress("track", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) return replay;
    replay.Feed(**pair);
    progress.Step();
  }
}

int RunTrack(const TrackArguments& arguments) {
  const auto replay = Replayed(arguments);
  if (!replay) return Fail("track", replay.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, replay->Text()); !written)
    return Fail("track", written.error());
  replay->PrintSummary(std::cout);
  return 0;
}

}  // namespace

void AddTrack(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("track", "the positions of the targets of a recording");
  auto arguments = std::make_shared<TrackArguments>();
  command->add_option("--recording", arguments->recording, "folder in EuRoC layout")->required();
  command->add_option("--rig", arguments->rig, "rig file of `adit calibrate`")->required();
  command->add_option("--model", arguments->models, "model of a target; several are allowed")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--out", arguments->out, "track file to write")->required();
  command->callback([arguments, &exit_code] { exit_code = RunTrack(*arguments); });
}

}  // namespace adit::host
