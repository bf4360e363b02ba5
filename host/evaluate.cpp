#include "host/evaluate.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/comparison.h"
#include "host/evaluate_report.h"
#include "host/failure.h"
#include "host/suites.h"

namespace adit::host {
namespace {

struct EvaluateArguments {
  std::string track, truth, json, report;
  int visible_min = 4;
  SuiteOrder suite;
};

int EvaluateTrack(const EvaluateArguments& arguments) {
  if (arguments.track.empty())
    return Fail("evaluate",
                {base::ErrorCode::kUsage, "--track", "is missing; give --track and --truth, or --suite"});
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
  std::vector<linux::FileText> figures;
  if (!arguments.json.empty()) figures.push_back({arguments.json, FormatJson(*comparison)});
  const ReportPage page = MakeEvaluateReport(*comparison, arguments.track, arguments.truth);
  if (auto written = WriteReport(page, {arguments.report, ""}, std::move(figures)); !written)
    return Fail("evaluate", written.error());
  std::cout << FormatTable(*comparison);
  return 0;
}

int Evaluate(const EvaluateArguments& arguments) {
  if (arguments.suite.suite.empty()) return EvaluateTrack(arguments);
  SuiteOrder order = arguments.suite;
  order.json = arguments.json;
  order.report = arguments.report;
  return RunSuite(order);
}

void AddSuiteOptions(CLI::App& command, SuiteOrder& order) {
  std::string names;
  for (const std::string& name : SuiteNames()) names += (names.empty() ? "" : ", ") + name;
  CLI::Option* suite = command.add_option("--suite", order.suite, "run a campaign in simulation: " + names);
  command.add_option("--case", order.only, "only this case of the suite")->needs(suite);
  command
      .add_option(
          "--count", order.count,
          "how much of it; by default little enough for seconds, or for minutes what the bars of seed and "
          "calibration are for: 30 calibrations")
      ->needs(suite)
      ->check(CLI::Range(1, 1'000'000'000));
  command.add_option("--seed", order.seed, "of all that is random")->needs(suite)->capture_default_str();
}

}  // namespace

void AddEvaluate(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("evaluate", "compare a track with the truth, or measure adit itself");
  auto arguments = std::make_shared<EvaluateArguments>();
  AddSuiteOptions(*command, arguments->suite);
  CLI::Option* track = command->add_option("--track", arguments->track, "track file of `adit track`");
  CLI::Option* truth = command->add_option("--truth", arguments->truth, "truth file of `adit simulate`");
  track->needs(truth)->excludes("--suite");
  truth->needs(track);
  command->add_option("--json", arguments->json, "also write the figures here");
  command->add_option("--report", arguments->report, "also write a page with plots here");
  command
      ->add_option("--min-visible", arguments->visible_min,
                   "LEDs that both cameras must see for a target to count as visible")
      ->check(CLI::Range(0, 4))
      ->capture_default_str();
  command->callback([arguments, &exit_code] { exit_code = Evaluate(*arguments); });
}

}  // namespace adit::host
