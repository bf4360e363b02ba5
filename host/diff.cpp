#include "host/diff.h"

#include <iostream>
#include <memory>
#include <string>

#include "drivers/linux/atomic_file.h"
#include "host/failure.h"
#include "host/track_difference.h"

namespace adit::host {
namespace {

struct DiffArguments {
  std::string a, b, json;
  double tolerance_m = 0;
};

int Diff(const DiffArguments& arguments) {
  const auto a = pipeline::LoadTrack(arguments.a);
  if (!a) return Fail("diff", a.error());
  const auto b = pipeline::LoadTrack(arguments.b);
  if (!b) return Fail("diff", b.error());
  const TrackDifference difference = CompareTracks(*a, *b);
  if (!arguments.json.empty()) {
    const std::string json = FormatDifferenceJson(difference, arguments.tolerance_m);
    if (auto written = linux::WriteFileAtomically(arguments.json, json); !written)
      return Fail("diff", written.error());
  }
  const bool same = difference.Same(arguments.tolerance_m);
  std::cout << FormatDifferenceTable(difference) << (same ? "the same\n" : "different\n");
  return same ? 0 : 1;
}

}  // namespace

void AddDiff(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("diff", "compare two tracks of one recording; exit 1 if they differ");
  auto arguments = std::make_shared<DiffArguments>();
  command->add_option("a", arguments->a, "track file of `adit track`")->required();
  command->add_option("b", arguments->b, "another one")->required();
  command
      ->add_option("--tolerance-m", arguments->tolerance_m, "positions that differ by no more are the same")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--json", arguments->json, "also write the figures here");
  command->callback([arguments, &exit_code] { exit_code = Diff(*arguments); });
}

}  // namespace adit::host
