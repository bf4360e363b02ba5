// The few calls that the SocketCAN bus makes of the kernel, so that its logic runs against a fake as well.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "firmware/base/can_frame.h"
#include "firmware/base/result.h"

namespace adit::socketcan {

enum class WriteOutcome : std::uint8_t {
  kTaken,  ///< the kernel has it
  kFull,   ///< no room in the queue of the interface (ENOBUFS, EAGAIN)
  kDown,   ///< the interface is down or gone
};

/// What came out of the socket.
struct ReceivedFrame {
  base::CanFrame frame;
  bool own = false;               ///< the echo of a frame of this socket: it was on the bus
  bool error = false;             ///< an error frame; `error_class` says which
  std::uint32_t error_class = 0;  ///< the bits of CAN_ERR_* in the id (linux/can/error.h)
};

class CanSocket {
 public:
  virtual ~CanSocket() = default;
  virtual WriteOutcome Write(const base::CanFrame& frame) = 0;
  /// The next waiting frame; never blocks.
  virtual std::optional<ReceivedFrame> Read() = 0;
  /// Takes the interface down and up again: empties its queue and the controller's, and ends bus-off. False
  /// if that was not allowed or did not work.
  virtual bool CycleInterface() = 0;
};

/// AF_CAN, raw, non-blocking, own messages echoed, error frames on. Declines with one line that names the
/// interface: the kernel has no CAN, there is no such interface, or it is not a CAN interface.
base::Result<std::unique_ptr<CanSocket>> OpenKernelCanSocket(const std::string& interface_name);

}  // namespace adit::socketcan
