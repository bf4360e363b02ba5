// Follows a candump log while it is being written, and believes of it what a machine would.
#pragma once

#include <fstream>
#include <optional>
#include <string>

#include "firmware/base/can_frame.h"
#include "firmware/publish/can_receiver.h"

namespace adit::host {

/// One line of the log format of `candump -L`: "(seconds.microseconds) channel ID#DATA".
struct LoggedFrame {
  base::TimeNs time_ns = 0;
  base::CanFrame frame;
};

/// Declines a line that is not of the format.
std::optional<LoggedFrame> ParseCandump(const std::string& line);

/// One target on the bus.
class BusReader {
 public:
  /// The file may appear later.
  BusReader(std::string path, std::uint8_t node);

  /// Takes all whole lines that came since the last call; returns how many frames of this node's slots were
  /// among them.
  std::size_t Follow();

  publish::CanReceiver& Receiver() { return receiver_; }
  std::uint64_t BadLines() const { return bad_lines_; }
  base::TimeNs LastFrameNs() const { return last_frame_ns_; }

 private:
  std::string path_;
  std::uint8_t node_;
  std::ifstream file_;
  std::string partial_;
  publish::CanReceiver receiver_;
  std::uint64_t bad_lines_ = 0;
  base::TimeNs last_frame_ns_ = base::kNever;
};

}  // namespace adit::host
