#include "host/train.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/optics/rig.h"
#include "host/bar_finder.h"
#include "host/failure.h"
#include "host/pair_reader.h"
#include "host/progress.h"
#include "host/training.h"

namespace adit::host {
namespace {

constexpr double kRadPerTiltDeg = 3.14159265358979323846 / 180;

struct TrainArguments {
  std::string target, out, camera, distances = "5:110";
  std::vector<std::string> recordings;
  double noise_px = 0.05, tilt_max_deg = 60;
};

/// "5:110" -> nearest and farthest distance.
base::Result<void> ReadDistances(const std::string& text, TrainingOptions& options) {
  std::istringstream in(text);
  char colon = 0;
  const bool read = static_cast<bool>(in >> options.nearest_m >> colon >> options.farthest_m);
  if (!read || !in.eof() || colon != ':' || !(options.nearest_m >= 1) || !(options.farthest_m <= 500) ||
      !(options.nearest_m < options.farthest_m)) {
    return base::Error{base::ErrorCode::kUsage, "--distances",
                       "is '" + text + "'; it must be NEAREST:FARTHEST in metres, 1 to 500, ascending"};
  }
  return {};
}

/// The camera of one side of a recording: the file given, or the recording's own.
base::Result<optics::CameraModel> CameraOf(const TrainArguments& arguments, const std::string& recording,
                                           const std::string& side, std::string& file) {
  file = arguments.camera.empty() ? recording + "/" + side + "/sensor.yaml" : arguments.camera;
  return optics::LoadCamera(file);
}

/// Counts the hits of `wide` in all images of one recording.
base::Result<void> CountRecording(const TrainArguments& arguments, const std::string& recording,
                                  const identify::Model& wide, TrainingTally& tally) {
  std::string left_file, right_file;
  const auto left = CameraOf(arguments, recording, "cam0", left_file);
  if (!left) return left.error();
  const auto right = CameraOf(arguments, recording, "cam1", right_file);
  if (!right) return right.error();
  auto reader =
      PairReader::Open(recording, ImageSize::Of(*left, left_file), ImageSize::Of(*right, right_file));
  if (!reader) return reader.error();
  BarFinder finder(*left, *right, {wide});
  Progress progress("train", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) return {};
    finder.Search(**pair);
    Count(finder.Sightings(base::Side::kLeft), tally);
    Count(finder.Sightings(base::Side::kRight), tally);
    progress.Step();
  }
}

std::string GeometryText(const TrainArguments& arguments, const TrainingOptions& options) {
  std::ostringstream text;
  text << "geometry: " << options.nearest_m << " to " << options.farthest_m << " m, leaning up to "
       << arguments.tilt_max_deg << " deg, centroids " << options.noise_px << " px, focal length "
       << options.focal_px << " px" << (arguments.camera.empty() ? " (assumed: no camera given)" : "");
  return text.str();
}

base::Result<identify::Model> Trained(const TrainArguments& arguments) {
  const auto target = identify::LoadTarget(arguments.target);
  if (!target) return target.error();
  TrainingOptions options;
  options.noise_px = arguments.noise_px;
  options.tilt_max_rad = arguments.tilt_max_deg * kRadPerTiltDeg;
  if (auto read = ReadDistances(arguments.distances, options); !read) return read.error();
  if (!arguments.camera.empty()) {
    const auto camera = optics::LoadCamera(arguments.camera);
    if (!camera) return camera.error();
    options.focal_px = camera->fu_px;
  }
  identify::Model model = GeometryModel(*target, options);
  model.trained_on = GeometryText(arguments, options);
  if (arguments.recordings.empty()) return model;

  TrainingTally tally;
  for (const std::string& recording : arguments.recordings) {
    if (auto counted = CountRecording(arguments, recording, model, tally); !counted) return counted.error();
  }
  const std::string counts = std::to_string(tally.none + tally.one + tally.several) +
                             " images: " + std::to_string(tally.one) + " with one hit, " +
                             std::to_string(tally.none) + " with none, " + std::to_string(tally.several) +
                             " with several";
  if (tally.one == 0) {
    return base::Error{base::ErrorCode::kFailed, arguments.recordings.front(),
                       "shows '" + target->name + "' in no image exactly once (" + counts +
                           "); check leds_m in " + arguments.target};
  }
  std::cout << counts << "\n";
  identify::Model refined = RefinedModel(NoiseRanges(*target, options), tally);
  refined.trained_on = std::to_string(tally.one) + " images, and " + model.trained_on;
  return refined;
}

int RunTrain(const TrainArguments& arguments) {
  const auto model = Trained(arguments);
  if (!model) return Fail("train", model.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, identify::FormatModel(*model)); !written)
    return Fail("train", written.error());
  std::cout << std::setprecision(5) << model->target.name << ": p2 " << model->p2_min << " to "
            << model->p2_max << ", collinearity " << model->collinearity_max << ", length "
            << model->length_min_px << " to " << model->length_max_px << " px\n";
  return 0;
}

}  // namespace

void AddTrain(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("train", "a model from a target and, if given, recordings of it");
  auto arguments = std::make_shared<TrainArguments>();
  command->add_option("--target", arguments->target, "target file")->required();
  command->add_option("--out", arguments->out, "model file to write")->required();
  command->add_option("--recording", arguments->recordings, "folder in EuRoC layout; several are allowed")
      ->expected(1)
      ->take_all();
  command->add_option("--camera", arguments->camera, "sensor.yaml of the cameras");
  command->add_option("--distances", arguments->distances, "NEAREST:FARTHEST, m")->capture_default_str();
  command->add_option("--tilt-deg", arguments->tilt_max_deg, "how far the bar leans from across the view")
      ->check(CLI::Range(0.0, 80.0))
      ->capture_default_str();
  command->add_option("--noise-px", arguments->noise_px, "standard deviation of a centroid")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  command->callback([arguments, &exit_code] { exit_code = RunTrain(*arguments); });
}

}  // namespace adit::host
