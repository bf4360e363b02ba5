// The machine's field bus as the box needs it: CAN frames out, their echoes back.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/base/can_frame.h"
#include "firmware/base/time.h"

namespace adit::hal {

enum class SendOutcome : std::uint8_t {
  kSent,     ///< all frames were handed to the bus
  kBusy,     ///< an earlier epoch is still unconfirmed: nothing was sent
  kDropped,  ///< the queue was full (ENOBUFS): the epoch is incomplete and was abandoned
  kDown,     ///< the bus is off or the interface is away
};

/// What a bus counts; monotonic since Open.
struct FieldBusHealth {
  std::uint64_t sent_frames = 0;
  std::uint64_t confirmed_epochs = 0;
  std::uint64_t dropped_epochs = 0;
  std::uint64_t errors = 0;
  std::uint64_t bus_off = 0;
  bool stalled = false;  ///< an epoch has been waiting for its echo too long
};

/// One bus. All calls belong to one publisher thread.
class FieldBus {
 public:
  virtual ~FieldBus() = default;
  /// Hands over the frames of one epoch, in order; at most one epoch is in flight.
  virtual SendOutcome SendEpoch(std::span<const base::CanFrame> frames) = 0;
  /// Takes echoes and error frames, restarts after bus-off; call at least once a cycle.
  virtual void Poll(base::TimeNs now_ns) = 0;
  virtual FieldBusHealth Health() const = 0;
};

}  // namespace adit::hal
