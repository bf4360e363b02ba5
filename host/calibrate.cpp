#include "host/calibrate.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/optics/rig.h"
#include "host/bar_finder.h"
#include "host/calibrate_report.h"
#include "host/calibration.h"
#include "host/calibration_text.h"
#include "host/failure.h"
#include "host/model_list.h"
#include "host/pair_reader.h"
#include "host/progress.h"

namespace adit::host {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

struct CalibrateArguments {
  std::string recording, out;
  ReportFiles report;
  std::vector<std::string> models, cameras;
  double similarity_max_deg = 60;
};

/// The cameras and models that the command line names, and their bars in the recording.
base::Result<CalibrationInput> Gather(const CalibrateArguments& arguments) {
  const auto left = optics::LoadCamera(arguments.cameras[0]);
  if (!left) return left.error();
  const auto right = optics::LoadCamera(arguments.cameras[1]);
  if (!right) return right.error();
  CalibrationInput input{arguments.recording, *left, *right, {}, {}};
  const auto models = LoadModels(arguments.models);
  if (!models) return models.error();
  for (const identify::Model& model : *models) input.targets.push_back(model.target);
  auto reader = PairReader::Open(arguments.recording, ImageSize::Of(*left, arguments.cameras[0]),
                                 ImageSize::Of(*right, arguments.cameras[1]));
  if (!reader) return reader.error();
  BarFinder finder(*left, *right, *models);
  Progress progress("bars", reader->Pairs());
  for (;;) {
    const auto pair = reader->Next();
    if (!pair) return pair.error();
    if (!pair->has_value()) return input;
    finder.Search(**pair);
    finder.AppendBars(input.bars);
    progress.Step();
  }
}

std::vector<ReportFact> QualityFacts(const CalibrationQuality& quality) {
  const Eigen::Vector3d sigma_urad = 1e6 * quality.sigma_rad;
  return {{"baseline_m", "baseline", ReportNumber(quality.baseline_m, 4), "m"},
          {"baseline_sigma_mm", "its sigma", ReportNumber(1e3 * quality.baseline_sigma_m, 2), "mm"},
          {"pitch_sigma_urad", "sigma of pitch", ReportNumber(sigma_urad.x(), 1), "\u00b5rad"},
          {"yaw_sigma_urad", "of yaw", ReportNumber(sigma_urad.y(), 1), "\u00b5rad"},
          {"roll_sigma_urad", "of roll", ReportNumber(sigma_urad.z(), 1), "\u00b5rad"},
          {"rms_px", "rms of a coordinate", ReportNumber(quality.rms_px, 4), "px"},
          {"sigma0", "sigma0", ReportNumber(quality.sigma0, 2), ""},
          {"bar_bias_mm", "mean bar error", ReportNumber(1e3 * quality.bar_bias_m, 2), "mm"},
          {"bar_rms_mm", "rms of it", ReportNumber(1e3 * quality.bar_rms_m, 2), "mm"},
          {"nearest_m", "bars from", ReportNumber(quality.nearest_m, 1), "m"},
          {"farthest_m", "to", ReportNumber(quality.farthest_m, 1), "m"}};
}

int RunCalibrate(const CalibrateArguments& arguments) {
  const auto input = Gather(arguments);
  if (!input) return Fail("calibrate", input.error());
  CalibrationOptions options;
  options.similarity_max_rad = arguments.similarity_max_deg * kRadPerDeg;
  const auto calibration = Calibrate(*input, options);
  if (!calibration) return Fail("calibrate", calibration.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, FormatCalibration(*calibration)); !written)
    return Fail("calibrate", written.error());
  const CalibrationPicture picture{arguments.recording, calibration->rig, input->targets, input->bars,
                                   QualityFacts(calibration->quality)};
  if (auto written = WriteReport(MakeCalibrateReport(picture), arguments.report); !written)
    return Fail("calibrate", written.error());
  std::cout << Summary(calibration->quality);
  return 0;
}

}  // namespace

void AddCalibrate(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("calibrate", "a rig file from a recording of a waved bar");
  auto arguments = std::make_shared<CalibrateArguments>();
  command->add_option("--recording", arguments->recording, "folder in EuRoC layout")->required();
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
