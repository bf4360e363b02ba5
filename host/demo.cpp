#include "host/demo.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "drivers/linux/signals.h"
#include "drivers/linux/system_clock.h"
#include "host/demo_stage.h"
#include "host/demo_summary.h"
#include "host/demo_view.h"
#include "host/failure.h"

namespace adit::host {
namespace {

constexpr base::DurationNs kPictureNs = 100 * base::kNsPerMs;  // ten pictures a second are smooth enough
constexpr base::DurationNs kPlainNs = 2 * base::kNsPerS;       // between the lines in a pipe
constexpr double kSecondsMin = 3, kSecondsMax = 86400;

double SecondsSince(std::int64_t start_ns) {
  return static_cast<double>(linux::MonotonicNs() - start_ns) / static_cast<double>(base::kNsPerS);
}

void ReadModbus(DemoStage& stage, DemoRun& run) {
  const auto live = stage.Controller().ReadLive();
  run.modbus_reads += 1;
  if (!live || !live->crc_good || !live->whole) {
    run.modbus_bad += 1;
    return;
  }
  const auto bus = stage.Bus().front().Receiver().OffsetMetres();
  if (live->offset_m && bus) run.modbus_position_m = live->offset_m, run.bus_position_m = bus;
}

int RunDemo(const DemoOptions& options, linux::StopSignals& signals) {
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  std::cout << "starting two simulated cameras and aditd ..." << std::endl;
  auto stage = DemoStage::Start(options);
  if (!stage) return Fail("demo", stage.error());
  DemoRun run;
  const std::int64_t start_ns = linux::MonotonicNs();
  std::int64_t next_line_ns = start_ns + kPlainNs;
  if (terminal) std::cout << "\033[2J";
  while (SecondsSince(start_ns) < options.seconds && !signals.WaitFor(kPictureNs)) {
    if (auto poll = (*stage)->Poll(); !poll) return Fail("demo", poll.error());
    ReadModbus(**stage, run);
    if (terminal) {
      std::cout << "\033[H" << DrawDemo(**stage, SecondsSince(start_ns), options.seconds, true) << "\033[J"
                << std::flush;
    } else if (linux::MonotonicNs() >= next_line_ns) {
      next_line_ns += kPlainNs;
      std::cout << DemoLine(**stage, SecondsSince(start_ns)) << std::flush;
    }
  }
  run.seconds = SecondsSince(start_ns);
  run.daemon_cores = (*stage)->DaemonCores();
  run.camera_cores = (*stage)->CameraCores();
  (*stage)->Stop();
  const auto findings = Summarise(**stage, run);
  if (!findings) return Fail("demo", findings.error());
  std::cout << FormatFindings(*findings) << "  files in " << options.folder << "\n" << std::flush;
  return AllGood(*findings) ? 0 : 1;
}

}  // namespace

void AddDemo(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("demo", "simulated cameras, the real daemon, positions on CAN and Modbus");
  auto options = std::make_shared<DemoOptions>();
  command->add_option("--seconds", options->seconds, "how long")->check(CLI::Range(kSecondsMin, kSecondsMax));
  command->add_option("--scene", options->scene, "what the cameras see")->required();
  command->add_option("--out", options->folder, "folder for its files, made anew");
  command->callback([options, &exit_code] {
    linux::StopSignals signals;  // before any thread starts
    exit_code = RunDemo(*options, signals);
  });
}

}  // namespace adit::host
