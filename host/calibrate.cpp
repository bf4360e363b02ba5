#include "host/calibrate.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "firmware/optics/rig.h"
#include "host/bar_finder.h"
#include "host/calibrate_report.h"
#include "host/calibration.h"
#include "host/calibration_text.h"
#include "host/failure.h"
#include "host/intrinsic_prior.h"
#include "host/model_list.h"
#include "host/pair_reader.h"
#include "host/progress.h"
#include "host/repeated_path.h"

namespace adit::host {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

struct CalibrateArguments {
  std::vector<std::string> recordings, models, cameras;
  std::string out;
  ReportFiles report;
  double similarity_max_deg = 60;
  IntrinsicSigmas sigmas;
  double bar_sigma_mm = 0.1;
  bool keeps_intrinsics = false;
  bool takes_lights = false;
};

/// What is known of a camera beforehand.
base::Result<IntrinsicPrior> Prior(const CalibrateArguments& arguments, std::size_t which,
                                   const optics::CameraModel& camera) {
  if (arguments.keeps_intrinsics) return IntrinsicPrior{};
  return LoadPrior(arguments.cameras[which], arguments.sigmas, camera);
}

/// The bars of one recording.
base::Result<void> Search(const CalibrateArguments& arguments, std::size_t which,
                          const std::vector<identify::Model>& models, CalibrationInput& input) {
  auto reader = PairReader::Open(arguments.recordings[which], ImageSize::Of(input.left, arguments.cameras[0]),
                                 ImageSize::Of(input.right, arguments.cameras[1]));
  if (!reader) return reader.error();
  BarFinder finder(input.left, input.right, models);
  RestFinder left_rest, right_rest;
  Progress progress("bars", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) break;
    finder.Search((*pair)->Frame(base::Side::kLeft), (*pair)->Frame(base::Side::kRight));
    const std::size_t first = input.bars.size();
    finder.AppendBars(input.bars);
    if (arguments.takes_lights) {
      left_rest.Add(*finder.Sightings(base::Side::kLeft).blob_set);
      right_rest.Add(*finder.Sightings(base::Side::kRight).blob_set);
    }
    for (std::size_t i = first; i < input.bars.size(); ++i)
      input.bars[i].recording = static_cast<std::uint16_t>(which);
    progress.Step();
  }
  if (arguments.takes_lights)
    input.lights.push_back({left_rest.Lights(input.left), right_rest.Lights(input.right)});
  return {};
}

/// The cameras and models that the command line names, and their bars in the recordings.
base::Result<CalibrationInput> Gather(const CalibrateArguments& arguments) {
  // Each bar would count twice, and every sigma be too small.
  if (const auto repeated = RepeatedPath(arguments.recordings))
    return base::Error{base::ErrorCode::kUsage, *repeated, "is named twice"};
  const auto left = optics::LoadCamera(arguments.cameras[0]);
  if (!left) return left.error();
  const auto right = optics::LoadCamera(arguments.cameras[1]);
  if (!right) return right.error();
  const auto left_prior = Prior(arguments, 0, *left);
  if (!left_prior) return left_prior.error();
  const auto right_prior = Prior(arguments, 1, *right);
  if (!right_prior) return right_prior.error();
  CalibrationInput input;
  input.recordings = arguments.recordings;
  input.left = *left, input.right = *right;
  input.left_prior = *left_prior, input.right_prior = *right_prior;
  input.bar_sigma_m = arguments.bar_sigma_mm * 1e-3;
  const auto models = LoadModels(arguments.models);
  if (!models) return models.error();
  for (const identify::Model& model : *models) input.targets.push_back(model.target);
  for (std::size_t i = 0; i < arguments.recordings.size(); ++i) {
    if (auto searched = Search(arguments, i, *models, input); !searched) return searched.error();
  }
  return input;
}

int RunCalibrate(const CalibrateArguments& arguments) {
  const auto input = Gather(arguments);
  if (!input) return Fail("calibrate", input.error());
  CalibrationOptions options;
  options.similarity_max_rad = arguments.similarity_max_deg * kRadPerDeg;
  const auto calibration = Calibrate(*input, options);
  if (!calibration) return Fail("calibrate", calibration.error());
  if (auto written = WriteReport(MakeCalibrateReport(*input, *calibration), arguments.report,
                                 {{arguments.out, FormatCalibration(*calibration)}});
      !written)
    return Fail("calibrate", written.error());
  std::cout << Summary(*calibration) << LightsText(*calibration, *input) << WrongPairs(*calibration, *input)
            << VerdictText(*calibration);
  return 0;
}

/// What may be wrong beforehand.
void AddPriors(CLI::App& command, CalibrateArguments& arguments) {
  command
      .add_option("--focal-sigma-pct", arguments.sigmas.focal_pct,
                  "what the focal length may be wrong by (1 sigma), if the camera file does not say")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str();
  command.add_option("--centre-sigma-px", arguments.sigmas.centre_px, "the principal point, likewise")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option("--distortion-sigma-px", arguments.sigmas.distortion_px,
                  "the distortion in the image's corner, likewise")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command
      .add_option("--bar-sigma-mm", arguments.bar_sigma_mm, "what a bar's length may be wrong by (1 sigma)")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_flag("--keep-intrinsics", arguments.keeps_intrinsics, "take the camera files as exact");
}

}  // namespace

void AddCalibrate(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("calibrate", "a rig file from a recording of a waved bar");
  auto arguments = std::make_shared<CalibrateArguments>();
  command->add_option("--recording", arguments->recordings, "folder in EuRoC layout; several are allowed")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--model", arguments->models, "model of a bar in it; several are allowed")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--camera", arguments->cameras, "sensor.yaml of cam0, then of cam1")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--out", arguments->out, "rig file to write")->required();
  command->add_option("--report", arguments->report.html, "also write a page with plots here");
  command->add_option("--json", arguments->report.json, "write the page's figures here");
  command
      ->add_option("--similarity-deg", arguments->similarity_max_deg,
                   "how far a bar's directions in both images may differ")
      ->check(CLI::Range(1.0, 180.0))
      ->capture_default_str();
  command->add_flag("--lights-at-rest", arguments->takes_lights,
                    "single LEDs that stand still count too, found by themselves: put some where the bar "
                    "cannot go, as in the images' corners");
  AddPriors(*command, *arguments);
  command->callback([arguments, &exit_code] {
    if (arguments->cameras.size() != 2) {
      exit_code = Fail("calibrate", {base::ErrorCode::kUsage, "--camera",
                                     "is given " + std::to_string(arguments->cameras.size()) +
                                         " times; it must be given twice: cam0, then cam1"});
      return;
    }
    exit_code = RunCalibrate(*arguments);
  });
}

}  // namespace adit::host
