// The field bus on Linux SocketCAN: at most one epoch in flight, confirmed by its own echoes.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "drivers/socketcan/can_socket.h"
#include "firmware/base/fixed_vector.h"
#include "hal/field_bus.h"

namespace adit::socketcan {

/// An epoch whose echoes have not come by then is given up: two cycles of the default 50 ms.
inline constexpr base::DurationNs kEchoLimitNs = 100 * base::kNsPerMs;
/// Back-off between restarts after bus-off or a stall, doubling.
inline constexpr base::DurationNs kBackOffMinNs = 100 * base::kNsPerMs;
inline constexpr base::DurationNs kBackOffMaxNs = 5 * base::kNsPerS;

/// Old frames survive in the queue of the interface and would be replayed when the bus comes back: a
/// machine would jump. So nothing new goes out before the old is confirmed on the bus or the interface was
/// emptied. One thread.
class SocketCanBus final : public hal::FieldBus {
 public:
  /// Opens the interface ("can0"). Declines as OpenKernelCanSocket does.
  static base::Result<std::unique_ptr<SocketCanBus>> Open(const std::string& interface_name);
  explicit SocketCanBus(std::unique_ptr<CanSocket> socket) : socket_(std::move(socket)) {}

  /// Frames of one epoch, up to kMaxEpochFrames. Dated by the last Poll.
  hal::SendOutcome SendEpoch(std::span<const base::CanFrame> frames) override;
  void Poll(base::TimeNs now_ns) override;
  hal::FieldBusHealth Health() const override { return health_; }

  /// All targets of a box may share one epoch: 32 of 11 frames. The queue of the interface must hold it
  /// (`ip link set can0 txqueuelen 1000`; the default of 10 does not hold two targets).
  static constexpr std::size_t kMaxEpochFrames = 352;

 private:
  void TakeEcho(const base::CanFrame& frame);
  void TakeError(std::uint32_t error_class);
  void GoDown();
  void TryRestart();

  std::unique_ptr<CanSocket> socket_;
  hal::FieldBusHealth health_;
  base::FixedVector<base::CanFrame, kMaxEpochFrames> in_flight_;
  std::size_t confirmed_ = 0;  ///< frames of in_flight_ whose echo came
  bool complete_ = false;      ///< in_flight_ is a whole epoch, not the rest of a dropped one
  bool down_ = false;
  base::TimeNs now_ns_ = base::kNever;
  base::TimeNs sent_ns_ = base::kNever;
  base::TimeNs restart_ns_ = base::kNever;
  base::DurationNs back_off_ns_ = kBackOffMinNs;
};

}  // namespace adit::socketcan
