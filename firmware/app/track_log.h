// The track log: a thread that writes one row per pair and target, in the format of `adit track`.
#pragma once

#include <atomic>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "board/sim/board.h"
#include "firmware/app/fix_record.h"
#include "firmware/base/result.h"

namespace adit::app {

/// Never in the way of the hot threads: it has a conveyor of its own, and what it is too slow for is dropped
/// and counted.
class TrackLog {
 public:
  /// Starts `path` anew with the header line. Declines with the file.
  base::Result<void> Open(const std::string& path, std::vector<std::string> target_names);
  ~TrackLog();

  void Start(LogConveyor& records);
  void Stop();
  board::Wakeup& Wake() { return wake_; }
  bool IsOpen() const { return file_.is_open(); }

 private:
  void Run(LogConveyor& records);
  void Drain(LogConveyor& records);

  std::ofstream file_;
  std::vector<std::string> names_;
  board::Wakeup wake_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
};

}  // namespace adit::app
