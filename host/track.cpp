#include "host/track.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "drivers/linux/atomic_file.h"
#include "host/failure.h"
#include "host/replay.h"

namespace adit::host {
namespace {

struct TrackArguments {
  ReplayOrder order;
  std::string out;
};

int RunTrack(const TrackArguments& arguments) {
  const auto track = ReplayRecording(arguments.order);
  if (!track) return Fail("track", track.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, track->text); !written)
    return Fail("track", written.error());
  track->PrintSummary(std::cout);
  return 0;
}

}  // namespace

void AddTrack(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("track", "the positions of the targets of a recording");
  auto arguments = std::make_shared<TrackArguments>();
  ReplayOrder& order = arguments->order;
  command->add_option("--recording", order.recording, "folder in EuRoC layout")->required();
  command->add_option("--rig", order.rig, "rig file of `adit calibrate`")->required();
  command->add_option("--model", order.models, "model of a target; several are allowed")
      ->required()
      ->expected(1)
      ->take_all();
  command->add_option("--body", order.bodies, "machine of two bars or more; several are allowed")
      ->expected(1)
      ->take_all();
  command->add_option("--georef", order.georeference,
                      "file of `adit georef`: positions are in the site frame, not in the rig's");
  command->add_flag("--filter", order.filter,
                    "smooth positions by a constant velocity filter and bridge short losses as predicted");
  command->add_option("--out", arguments->out, "track file to write")->required();
  command->callback([arguments, &exit_code] { exit_code = RunTrack(*arguments); });
}

}  // namespace adit::host
