#include "host/inspect.h"

#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "drivers/linux/atomic_file.h"
#include "host/failure.h"
#include "host/inspection_drawing.h"
#include "host/model_list.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

struct InspectArguments {
  std::string recording, rig, out;
  std::vector<std::string> models;
  std::optional<double> at_s;
  std::optional<std::size_t> pair;
};

/// The pair that was asked for.
base::Result<std::size_t> PairOf(const InspectArguments& arguments, const PairReader& reader) {
  const auto seconds = [&reader](std::size_t pair) {
    return static_cast<double>(reader.MidExposureNs(pair) - reader.MidExposureNs(0)) * 1e-9;
  };
  const std::size_t last = reader.Pairs() - 1;
  if (arguments.pair) {
    if (*arguments.pair <= last) return *arguments.pair;
    return Error{
        ErrorCode::kUsage, "--frame",
        "is " + std::to_string(*arguments.pair) + "; the recording has 0 to " + std::to_string(last)};
  }
  const double period_s = last == 0 ? 0 : seconds(last) / static_cast<double>(last);
  if (!(*arguments.at_s >= -period_s && *arguments.at_s <= seconds(last) + period_s)) {
    return Error{ErrorCode::kUsage, "--at",
                 "is " + std::to_string(*arguments.at_s) + " s; the recording lasts from 0 to " +
                     std::to_string(seconds(last)) + " s"};
  }
  std::size_t nearest = 0;
  for (std::size_t i = 0; i <= last; ++i) {
    if (std::abs(seconds(i) - *arguments.at_s) < std::abs(seconds(nearest) - *arguments.at_s)) nearest = i;
  }
  return nearest;
}

void PrintSummary(const Inspection& inspection, const DrawingOrder& order) {
  std::cout << order.title << "\n";
  for (const stereo::TargetPoints& target : inspection.result->points.targets) {
    const bool lost = target.status == stereo::FixStatus::kLost;
    std::cout << order.names[target.target] << ": " << (lost ? "lost: " + Explain(target.reason) : "found")
              << "\n";
  }
  for (const InspectedCandidate& candidate : inspection.candidates)
    std::cout << "candidate for " << order.names[candidate.sighting.target] << ": " << candidate.verdict
              << "\n";
}

base::Result<void> Inspect(const InspectArguments& arguments) {
  // Pairs before the one that is looked into: what is expected of a target comes of them.
  constexpr std::size_t kBefore = 20;
  const auto rig = optics::LoadRig(arguments.rig);
  if (!rig) return rig.error();
  const auto models = LoadModels(arguments.models);
  if (!models) return models.error();
  pipeline::PipelineOptions options;
  options.windows = false;
  auto pipeline = pipeline::Pipeline::Make(*rig, *models, options);
  if (!pipeline) return pipeline.error();
  auto reader = PairReader::Open(arguments.recording, ImageSize::Of(rig->left, arguments.rig),
                                 ImageSize::Of(rig->right, arguments.rig));
  if (!reader) return reader.error();
  const auto wanted = PairOf(arguments, *reader);
  if (!wanted) return wanted.error();
  Inspector inspector(*rig, *models, std::move(*pipeline));
  const std::size_t first = *wanted - std::min(kBefore, *wanted);
  reader->StartAt(first);
  for (std::size_t i = first;; ++i) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    const Inspection& inspection = inspector.Look(**pair);
    if (i < *wanted) continue;
    DrawingOrder order{&*rig, {}, {}};
    for (const identify::Model& model : *models) order.names.push_back(model.target.name);
    std::ostringstream title;
    title << "pair " << i << ", " << std::fixed << std::setprecision(3)
          << static_cast<double>(reader->MidExposureNs(i) - reader->MidExposureNs(0)) * 1e-9
          << " s, timestamp " << (*pair)->mid_exposure_ns << " ns";
    order.title = title.str();
    std::vector<std::uint8_t> png;
    cv::imencode(".png", DrawInspection(**pair, inspection, order), png);
    PrintSummary(inspection, order);
    return linux::WriteFileAtomically(arguments.out, {reinterpret_cast<const char*>(png.data()), png.size()});
  }
}

}  // namespace

void AddInspect(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("inspect", "why a pair of a recording gave what it gave, as a picture");
  auto arguments = std::make_shared<InspectArguments>();
  command->add_option("recording", arguments->recording, "folder in EuRoC layout")->required();
  auto* when = command->add_option_group("when", "the pair");
  when->add_option("--at", arguments->at_s, "seconds after the first pair");
  when->add_option("--frame", arguments->pair, "index of the pair, the first is 0");
  when->require_option(1);
  command->add_option("--rig", arguments->rig, "rig file of `adit calibrate`")->required();
  command->add_option("--model", arguments->models, "model of a target; several are allowed")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--out", arguments->out, "picture to write, PNG")->required();
  command->callback([arguments, &exit_code] {
    const auto done = Inspect(*arguments);
    exit_code = done ? 0 : Fail("inspect", done.error());
  });
}

}  // namespace adit::host
