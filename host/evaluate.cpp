#include "host/evaluate.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "drivers/linux/atomic_file.h"
#include "host/comparison.h"
#include "host/failure.h"

namespace adit::host {
namespace {

struct EvaluateArguments {
  std::string track, truth, json;
  int visible_min = 4;
};

int Evaluate(const EvaluateArguments& arguments) {
  const auto track = pipeline::LoadTrack(arguments.track);
  if (!track) return Fail("evaluate", track.error());
  const auto truth = sim::ReadTruth(arguments.truth);
  if (!truth) return Fail("evaluate", truth.error());
  auto comparison = Compare(*track, *truth, arguments.visible_min);
  if (!comparison) {
    base::Error error = comparison.error();
    error.where = arguments.truth;
    return Fail("evaluate", error);
  }
  if (!arguments.json.empty()) {
    if (auto written = linux::WriteFileAtomically(arguments.json, FormatJson(*comparison)); !written)
      return Fail("evaluate", written.error());
  }
  std::cout << FormatTable(*comparison);
  return 0;
}

}  // namespace

void AddEvaluate(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("evaluate", "compare a track with the truth");
  auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option("--track", arguments->track, "track file of `adit track`")->required();
  command->add_option("--truth", arguments->truth, "truth file of `adit simulate`")->required();
  command->add_option("--json", arguments->json, "also write the figures here");
  command
      ->add_option("--min-visible", arguments->visible_min,
                   "LEDs that both cameras must see for a target to count as visible")
      ->check(CLI::Range(0, 4))
      ->capture_default_str();
  command->callback([arguments, &exit_code] { exit_code = Evaluate(*arguments); });
}

}  // namespace adit::host
