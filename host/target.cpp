#include "host/target.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/identify/model.h"
#include "host/failure.h"
#include "host/target_design.h"

namespace adit::host {
namespace {

constexpr double kRadPerLeanDeg = 3.14159265358979323846 / 180;

struct DesignArguments {
  DesignOrder order;
  double tilt_deg = 20;
  std::string out;
};

base::Result<void> WriteTargets(const TargetDesign& design, const std::string& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return base::Error{base::ErrorCode::kNotFound, folder, "cannot be made: " + failed.message()};
  std::vector<linux::FileText> files;
  for (const base::Target& target : design.targets) {
    files.push_back(
        {(std::filesystem::path(folder) / (target.name + ".yaml")).string(), identify::FormatTarget(target)});
  }
  return linux::WriteFilesAtomically(files);
}

int RunDesign(DesignArguments arguments) {
  const char* const name = "target design";
  arguments.order.view.tilt_max_rad = arguments.tilt_deg * kRadPerLeanDeg;
  const auto design = DesignTargets(arguments.order);
  if (!design) return Fail(name, design.error());
  if (!arguments.out.empty()) {
    if (auto written = WriteTargets(*design, arguments.out); !written) return Fail(name, written.error());
  }
  std::cout << FormatDesign(*design, arguments.order);
  return 0;
}

}  // namespace

void AddTarget(CLI::App& app, int& exit_code) {
  CLI::App* target = app.add_subcommand("target", "line targets");
  target->require_subcommand(1);
  CLI::App* design =
      target->add_subcommand("design", "bars of one length that cannot be taken for each other");
  auto arguments = std::make_shared<DesignArguments>();
  DesignOrder& order = arguments->order;
  design->add_option("--length-m", order.length_m, "LED 1 to LED 4")
      ->required()
      ->check(CLI::Range(0.1, 10.0));
  design->add_option("--gap-min-m", order.gap_min_m, "smallest distance of two LEDs")
      ->check(CLI::Range(0.01, 3.0))
      ->capture_default_str();
  design->add_option("--distance-m", order.distance_m, "as far as the bars must be told apart")
      ->required()
      ->check(CLI::Range(1.0, 500.0));
  design->add_option("--noise-px", order.view.noise_px, "standard deviation of a centroid")
      ->required()
      ->check(CLI::Range(0.001, 1.0));
  design->add_option("--count", order.count, "bars wanted; by default as many as fit")
      ->check(CLI::Range(1, 99));
  design->add_option("--tilt-deg", arguments->tilt_deg, "how far a bar leans from across the view")
      ->check(CLI::Range(0.0, 80.0))
      ->capture_default_str();
  design->add_option("--focal-px", order.view.focal_px, "focal length")
      ->check(CLI::Range(100.0, 100'000.0))
      ->capture_default_str();
  design
      ->add_option("--spot-px", order.spot_sigma_px,
                   "sigma of an LED's image: nearer than 4.75 of it spots merge")
      ->check(CLI::Range(0.3, 10.0))
      ->capture_default_str();
  design->add_option("--out", arguments->out, "folder for the target files");
  design->callback([arguments, &exit_code] { exit_code = RunDesign(*arguments); });
}

}  // namespace adit::host
