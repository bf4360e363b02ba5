// The stage of `adit demo`: the files it needs, the simulated cameras, the daemon, and the clients that watch
// them.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/process.h"
#include "firmware/base/result.h"
#include "host/bus_reader.h"
#include "host/plc.h"

namespace adit::host {

struct DemoOptions {
  std::string folder = "build/demo";  ///< made anew
  std::string scene;                  ///< scene file
  double seconds = 30;
};

/// The last status line of aditd, taken apart.
using StatusWords = std::map<std::string, std::string>;
/// Splits "status key=value key=value"; words without '=' get an empty value.
StatusWords ParseStatus(const std::string& line);
/// The number of a word ("a/b": the first or second); 0 if it is not there.
double NumberOf(const StatusWords& words, const std::string& key, int part = 0);

/// Everything that runs during the demo. Belongs to one thread; destruction stops all processes.
class DemoStage {
 public:
  /// Writes the files, starts the cameras and the daemon, waits until it runs. Declines with the step that
  /// failed.
  static base::Result<std::unique_ptr<DemoStage>> Start(const DemoOptions& options);

  /// Reads what the daemon and the bus said since the last call. Declines if a process ended early.
  base::Result<void> Poll();
  /// Ends daemon and cameras in this order; the files are complete then.
  void Stop();

  const StatusWords& Status() const { return status_; }
  const std::vector<std::string>& Targets() const { return targets_; }
  std::vector<BusReader>& Bus() { return bus_; }
  Plc& Controller() { return *plc_; }
  std::string Path(const std::string& file) const { return options_.folder + "/" + file; }
  /// Processor time so far, in cores: daemon and cameras.
  double DaemonCores() const;
  double CameraCores() const;

 private:
  explicit DemoStage(const DemoOptions& options) : options_(options) {}
  base::Result<void> WriteFiles();
  base::Result<void> StartCameras();
  base::Result<void> StartDaemon();

  DemoOptions options_;
  std::vector<std::string> targets_;
  std::optional<linux::Process> cameras_, daemon_;
  std::optional<Plc> plc_;
  std::vector<BusReader> bus_;
  StatusWords status_;
  std::int64_t started_ns_ = 0;
};

}  // namespace adit::host
