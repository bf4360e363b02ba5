#include "host/train.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/optics/rig.h"
#include "host/failure.h"
#include "host/repeated_path.h"
#include "host/train_report.h"
#include "host/train_session.h"

namespace adit::host {
namespace {

constexpr double kRadPerTiltDeg = 3.14159265358979323846 / 180;
constexpr std::size_t kProblemLines = 20;

struct TrainArguments {
  std::string target, out, camera, distances = "5:110";
  std::vector<std::string> recordings, others;
  std::vector<base::TimeNs> discarded;
  bool apply = false;
  ReportFiles report;
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

std::string GeometryText(const TrainArguments& arguments, const TrainingOptions& options) {
  std::ostringstream text;
  text << "geometry: " << options.nearest_m << " to " << options.farthest_m << " m, leaning up to "
       << arguments.tilt_max_deg << " deg, centroids " << options.noise_px << " px, focal length "
       << options.focal_px << " px" << (arguments.camera.empty() ? " (assumed: no camera given)" : "");
  return text.str();
}

base::Result<TrainOrder> OrderOf(const TrainArguments& arguments) {
  TrainOrder order;
  const auto target = identify::LoadTarget(arguments.target);
  if (!target) return target.error();
  order.target = *target;
  order.target_file = arguments.target;
  order.camera = arguments.camera;
  order.options.noise_px = arguments.noise_px;
  order.options.tilt_max_rad = arguments.tilt_max_deg * kRadPerTiltDeg;
  if (auto read = ReadDistances(arguments.distances, order.options); !read) return read.error();
  if (const auto repeated = RepeatedPath(arguments.recordings))
    return base::Error{base::ErrorCode::kUsage, *repeated, "is named twice"};
  // The model is for all cameras that see the target; the first recording's stands for them.
  const std::string camera_file = !arguments.camera.empty() || arguments.recordings.empty()
                                      ? arguments.camera
                                      : arguments.recordings[0] + "/cam0/sensor.yaml";
  if (!camera_file.empty()) {
    const auto camera = optics::LoadCamera(camera_file);
    if (!camera) return camera.error();
    order.options.focal_px = camera->fu_px;
    order.size_px = {camera->width_px, camera->height_px};
  }
  order.recordings = arguments.recordings;
  order.discarded = arguments.discarded;
  order.apply = arguments.apply;
  for (const std::string& file : arguments.others) {
    const auto other = identify::LoadModel(file);
    if (!other) return other.error();
    order.others.push_back(*other);
  }
  return order;
}

void PrintReview(const Training& training) {
  const TrainingReview& review = training.review;
  std::cout << training.images.size() << " images: " << review.one << " with one hit, " << review.none
            << " with none (" << review.absent << " of them with nothing like it), " << review.several
            << " with several\n";
  for (const std::string& applied : training.applied) std::cout << "  done: " << applied << "\n";
  std::size_t shown = 0;
  for (const ImageProblem& problem : review.problems) {
    if (++shown > kProblemLines) break;
    const TrainingImage& image = training.images[problem.image];
    std::cout << "  " << image.mid_exposure_ns << (image.side == base::Side::kLeft ? " cam0: " : " cam1: ")
              << problem.finding << "; " << problem.proposal << "\n";
  }
  if (review.problems.size() > kProblemLines)
    std::cout << "  and " << review.problems.size() - kProblemLines << " more: --report\n";
}

int RunTrain(const TrainArguments& arguments) {
  const auto order = OrderOf(arguments);
  if (!order) return Fail("train", order.error());
  auto training = Train(*order);
  if (!training) return Fail("train", training.error());
  identify::Model& model = training->model;
  model.trained_on =
      (training->images.empty() ? "" : std::to_string(training->review.one) + " images, and ") +
      GeometryText(arguments, order->options);
  if (auto written = WriteReport(MakeTrainReport(*training), arguments.report,
                                 {{arguments.out, identify::FormatModel(model)}});
      !written)
    return Fail("train", written.error());
  if (!training->images.empty()) PrintReview(*training);
  for (const std::string& warning : TrainingWarnings(*training)) std::cout << "note: " << warning << "\n";
  std::cout << std::setprecision(5) << model.target.name << ": p2 " << model.p2_min << " to " << model.p2_max
            << ", collinearity " << model.collinearity_max << ", length " << model.length_min_px << " to "
            << model.length_max_px << " px\n";
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
  command->add_option("--other", arguments->others, "model of a target that must not be taken for this one")
      ->expected(1)
      ->take_all();
  command->add_flag("--apply", arguments->apply, "take over the values that are proposed for problem images");
  command->add_option("--discard", arguments->discarded, "times of images to leave out, ns");
  command->add_option("--report", arguments->report.html, "write a page with plots here");
  command->add_option("--json", arguments->report.json, "write the page's figures here");
  command->callback([arguments, &exit_code] { exit_code = RunTrain(*arguments); });
}

}  // namespace adit::host
