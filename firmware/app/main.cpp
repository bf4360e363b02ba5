// aditd: the daemon of the box.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "firmware/app/box.h"

namespace {

constexpr adit::base::DurationNs kStatusNs = adit::base::kNsPerS;
constexpr adit::base::DurationNs kLookNs =
    50 * adit::base::kNsPerMs;  // how soon the end of a recording is noticed

int Fail(const adit::base::Error& error) {
  std::cerr << "aditd: " << error.Line() << "\n";
  return error.ExitCode();
}

/// Tells the operator once when the calibration ceases to hold, and again after it had held.
void TellChange(const adit::app::Status& status, const std::string& rig_path, bool& told) {
  const bool changed = status.finding && status.finding->verdict == adit::watch::Verdict::kChanged;
  if (changed && !told)
    std::cerr << "aditd: " << adit::app::FormatAdvice(*status.finding, rig_path) << std::endl;
  told = changed;
}

int Run(const std::string& path, bool with_status, adit::board::StopSignals& signals) {
  const auto config = adit::config::LoadBoxConfig(path);
  if (!config) return Fail(config.error());
  auto box = adit::app::Box::Make(*config);
  if (!box) return Fail(box.error());
  if (auto start = (*box)->Start(); !start) return Fail(start.error());
  if (with_status) {
    const std::string report = adit::board::RealtimeReport();
    if (!report.empty()) std::cout << "realtime " << report << std::endl;
    std::cout << "running" << std::endl;
  }
  std::int64_t next_ns = adit::board::MonotonicNs() + kStatusNs;
  bool stop = false, told_change = false;
  while (!stop && !(*box)->Ended()) {
    stop = signals.WaitFor(kLookNs);
    if (adit::board::MonotonicNs() < next_ns && !stop) continue;
    next_ns += kStatusNs;
    const adit::app::Status status = (*box)->TakeStatus();
    // A report that cannot be written now has become old: its readers see that.
    (void)(*box)->WriteHealth(status);
    if (with_status) std::cout << adit::app::FormatStatus(status) << std::endl;
    if (with_status && status.finding) std::cout << adit::app::FormatFinding(*status.finding) << std::endl;
    TellChange(status, config->Resolve(config->rig), told_change);
  }
  (*box)->Stop();
  const adit::app::Status last = (*box)->TakeStatus();
  if (with_status) std::cout << adit::app::FormatStatus(last) << "\nstopped" << std::endl;
  const auto written = (*box)->WriteHealth(last);
  return written ? 0 : Fail(written.error());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"aditd: finds targets in the images of two cameras and tells machines where they are"};
  std::string config_path;
  bool with_status = false;
  app.add_option("--config", config_path, "the box's configuration (adit config schema)")->required();
  app.add_flag("--status", with_status, "a status line per second on stdout");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    std::cerr << "aditd: " << e.what() << " (aditd --help)\n";
    return 2;
  }
  adit::board::StopSignals signals;  // before any thread starts: they inherit the mask
  return Run(config_path, with_status, signals);
}
