#include "host/georef.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware/optics/rig.h"
#include "host/failure.h"
#include "host/georef_page.h"
#include "host/georef_report.h"
#include "host/provenance.h"
#include "host/replay.h"

namespace adit::host {
namespace {

constexpr double kRadOfDegree = 3.14159265358979323846 / 180;

struct GeorefArguments {
  ReplayOrder replay;
  std::string track, points, out, surveyor;
  ReportFiles report;
  int parameters = 6;
  double grid_scale_factor = 1, pitch_deg = 0, roll_deg = 0;
  double control_sigma_mm = 2, rms_limit_mm = 3, residual_limit_mm = 5;
  std::vector<std::string> pairs, excluded;
  std::vector<double> gsi8_offset_m;
};

base::Error Usage(const std::string& option, const std::string& detail) {
  return {base::ErrorCode::kUsage, option, detail};
}

base::Result<void> CheckArguments(const GeorefArguments& arguments) {
  const bool has_track = !arguments.track.empty(), has_recording = !arguments.replay.recording.empty();
  if (has_track == has_recording) return Usage("--track, --recording", "give one of the two");
  if (has_recording && arguments.replay.models.empty())
    return Usage("--model", "is missing; a recording needs the models of its targets");
  if (has_track && !arguments.replay.models.empty()) return Usage("--model", "goes with --recording only");
  if (arguments.parameters != 4 && (arguments.pitch_deg != 0 || arguments.roll_deg != 0))
    return Usage("--pitch-deg, --roll-deg", "go with --parameters 4 only; else they are estimated");
  return {};
}

base::Result<std::vector<pipeline::TrackRow>> ReadTrack(const GeorefArguments& arguments) {
  if (!arguments.track.empty()) return pipeline::LoadTrack(arguments.track);
  const auto replayed = ReplayRecording(arguments.replay);
  if (!replayed) return replayed.error();
  return pipeline::ParseTrack(replayed->text, arguments.replay.recording);
}

base::Result<MatchOptions> MatchOptionsOf(const GeorefArguments& arguments) {
  MatchOptions options;
  options.excluded = arguments.excluded;
  options.control_sigma_m = arguments.control_sigma_mm * 1e-3;
  for (const std::string& pair : arguments.pairs) {
    const std::size_t equals = pair.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == pair.size())
      return Usage("--pair " + pair, "must be POINT=TARGET or POINT=TARGET.LED");
    if (!options.pairs.emplace(pair.substr(0, equals), pair.substr(equals + 1)).second)
      return Usage("--pair " + pair, "gives this point a second time");
  }
  return options;
}

HelmertOptions HelmertOptionsOf(const GeorefArguments& arguments) {
  HelmertOptions options;
  options.estimate_tilt = arguments.parameters != 4;
  options.estimate_scale = arguments.parameters == 7;
  options.grid_scale_factor = arguments.grid_scale_factor;
  options.R_level_b = LevelFrame(arguments.pitch_deg * kRadOfDegree, arguments.roll_deg * kRadOfDegree);
  return options;
}

/// The points of the file that none of `matched` is.
std::vector<std::string> NamesWithout(const ControlFile& control, const std::vector<MatchedPoint>& matched) {
  std::vector<std::string> names;
  for (const ControlPoint& point : control.points) {
    const auto is_it = [&point](const MatchedPoint& match) { return match.common.name == point.name; };
    if (std::none_of(matched.begin(), matched.end(), is_it)) names.push_back(point.name);
  }
  return names;
}

struct GeorefOutcome {
  Georeferencing result;
  GeorefOrigin origin;
};

base::Result<GeorefOutcome> Georeference(const GeorefArguments& arguments) {
  const auto rig = optics::LoadRig(arguments.replay.rig);
  if (!rig) return rig.error();
  std::optional<Eigen::Vector3d> gsi8_offset_m;
  if (!arguments.gsi8_offset_m.empty()) gsi8_offset_m = Eigen::Vector3d(arguments.gsi8_offset_m.data());
  const auto control = LoadControlPoints(arguments.points, gsi8_offset_m);
  if (!control) return control.error();
  const auto match_options = MatchOptionsOf(arguments);
  if (!match_options) return match_options.error();
  const auto track = ReadTrack(arguments);
  if (!track) return track.error();
  auto points = MatchPoints(*control, *track, *match_options);
  if (!points) return points.error();
  std::vector<std::string> unmatched = NamesWithout(*control, *points);
  auto result = Adjust(std::move(*points), HelmertOptionsOf(arguments),
                       {arguments.rms_limit_mm * 1e-3, arguments.residual_limit_mm * 1e-3});
  if (!result) return base::Error{result.error().code, arguments.points, result.error().detail};
  base::TimeNs newest_ns = 0;
  for (const pipeline::TrackRow& row : *track) newest_ns = std::max(newest_ns, row.timestamp_ns);
  GeorefOrigin origin{control->path,
                      control->crc32,
                      arguments.track.empty() ? arguments.replay.recording : arguments.track,
                      rig->calibration_id,
                      Utc(newest_ns),
                      arguments.surveyor,
                      std::nullopt,
                      std::move(unmatched)};
  if (const auto previous = georef::LoadOrientation(arguments.out, rig->calibration_id))
    origin.previous = *previous;
  return GeorefOutcome{std::move(*result), std::move(origin)};
}

int RunGeoref(const GeorefArguments& arguments) {
  if (auto checked = CheckArguments(arguments); !checked) return Fail("georef", checked.error());
  const auto outcome = Georeference(arguments);
  if (!outcome) return Fail("georef", outcome.error());
  std::cout << FormatGeorefReport(outcome->result, outcome->origin) << std::flush;
  const auto refusal = outcome->result.Refusal();
  std::vector<linux::FileText> results;
  if (!refusal) results.push_back({arguments.out, FormatGeorefFile(outcome->result, outcome->origin)});
  if (auto written =
          WriteReport(MakeGeorefPage(outcome->result, outcome->origin), arguments.report, std::move(results));
      !written)
    return Fail("georef", written.error());
  if (refusal) return Fail("georef", {base::ErrorCode::kFailed, arguments.points, *refusal});
  return 0;
}

void AddInputs(CLI::App* command, GeorefArguments& arguments) {
  command->add_option("--rig", arguments.replay.rig, "rig file of `adit calibrate`")->required();
  command->add_option("--track", arguments.track, "track file of `adit track`, in the rig frame");
  command->add_option("--recording", arguments.replay.recording, "or a recording, with its models");
  command->add_option("--model", arguments.replay.models, "model of a target in the recording")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--points", arguments.points,
                   "control points, .csv or .gsi, named TARGET or TARGET.1 to TARGET.4 (LEDs)")
      ->required();
  command->add_option("--pair", arguments.pairs, "POINT=TARGET or POINT=TARGET.LED, where names differ")
      ->expected(1)
      ->take_all();
  command->add_option("--exclude", arguments.excluded, "control point to compare but not to use")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--gsi8-offset-m", arguments.gsi8_offset_m,
                   "E N H to add to GSI-8 coordinates, which have no room for national ones")
      ->expected(3);
}

void AddModel(CLI::App* command, GeorefArguments& arguments) {
  command
      ->add_option("--parameters", arguments.parameters,
                   "6; 4: the rig is levelled; 7: with scale, for diagnosis, the box refuses it")
      ->check(CLI::IsMember({4, 6, 7}))
      ->capture_default_str();
  command->add_option("--scale-factor", arguments.grid_scale_factor, "of the site's grid, such as 0.9996")
      ->check(CLI::Range(0.99, 1.01))
      ->capture_default_str();
  command->add_option("--pitch-deg", arguments.pitch_deg, "with 4 parameters: cam0's axis upwards")
      ->check(CLI::Range(-80.0, 80.0))
      ->capture_default_str();
  command->add_option("--roll-deg", arguments.roll_deg, "with 4 parameters: cam0's right side downwards")
      ->check(CLI::Range(-180.0, 180.0))
      ->capture_default_str();
}

void AddJudgement(CLI::App* command, GeorefArguments& arguments) {
  command
      ->add_option("--control-sigma-mm", arguments.control_sigma_mm,
                   "of a control coordinate where the file has no sigma_m")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  command->add_option("--rms-limit-mm", arguments.rms_limit_mm, "largest rms of the residuals, 3D")
      ->check(CLI::Range(0.01, 1e4))
      ->capture_default_str();
  command->add_option("--residual-limit-mm", arguments.residual_limit_mm, "largest residual of a point, 3D")
      ->check(CLI::Range(0.01, 1e4))
      ->capture_default_str();
  command->add_option("--operator", arguments.surveyor, "who georeferences, for the report");
  command->add_option("--out", arguments.out, "georeference file to write")->required();
  command->add_option("--report", arguments.report.html, "also write a page with plots here, refused or not");
  command->add_option("--json", arguments.report.json, "write the page's figures here");
}

}  // namespace

void AddGeoref(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("georef", "the rig in the site grid, from control points");
  auto arguments = std::make_shared<GeorefArguments>();
  AddInputs(command, *arguments);
  AddModel(command, *arguments);
  AddJudgement(command, *arguments);
  command->callback([arguments, &exit_code] { exit_code = RunGeoref(*arguments); });
}

}  // namespace adit::host
