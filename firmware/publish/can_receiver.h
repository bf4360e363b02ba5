// The receiver's rule of adit-CAN 1.0: what a machine controller must do before it believes a position.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/base/can_frame.h"
#include "firmware/base/time.h"
#include "firmware/publish/epoch.h"

namespace adit::publish {

/// A frame of the common shape whose CRC held, taken apart.
struct ReceivedSlot {
  std::uint8_t slot = 0;
  std::uint32_t value = 0;  ///< bytes 0-3
  Validity validity = Validity::kInvalid;
  std::uint8_t age = 0;  ///< x 4 ms; 63: 252 ms or more, or unknown
  std::uint8_t counter = 0;
};

/// Which slot of `node` a frame is; nothing if it is none.
std::optional<std::uint8_t> SlotOf(const base::CanFrame& frame, std::uint8_t node);

/// Takes a frame of `node` apart. Declines if it is none of its slots, not 8 bytes long, or its CRC does
/// not hold.
std::optional<ReceivedSlot> DecodeSlot(const base::CanFrame& frame, std::uint8_t node);

struct ReceiverRules {
  base::DurationNs age_limit_ns = 100 * base::kNsPerMs;
  base::DurationNs timeout_ns = 150 * base::kNsPerMs;  ///< without an accepted epoch: safe reaction
  int good_epochs = 3;                                 ///< in a row, to come back
  bool accept_simulated = false;  ///< for test stands and demonstrations; never on a machine
};

struct ReceiverCounts {
  std::uint64_t frames = 0;  ///< of this node's slots
  std::uint64_t crc_errors = 0;
  std::uint64_t epochs = 0;  ///< E, N and H of one counter
  std::uint64_t accepted = 0;
  std::uint64_t not_valid = 0;    ///< refused: validity
  std::uint64_t too_old = 0;      ///< refused: age
  std::uint64_t out_of_step = 0;  ///< refused: the counter did not move, or by more than 3
};

/// Accepts an epoch if the CRC of E, N and H holds, their counters are equal and moved by 1 to 3 since the
/// last epoch, validity is VALID and the age within its limit. One thread; no heap.
class CanReceiver {
 public:
  explicit CanReceiver(std::uint8_t node, const ReceiverRules& rules = {}) : node_(node), rules_(rules) {}

  /// Any frame from the bus; foreign ones are passed over.
  void Accept(const base::CanFrame& frame, base::TimeNs received_ns);

  /// Whether the machine may move by OffsetMetres() now. False from the start until enough good epochs came
  /// in a row, and whenever none was accepted for the timeout.
  bool Good(base::TimeNs now_ns);

  /// Of the last accepted epoch: E, N, H as difference from the origin.
  std::optional<std::array<double, 3>> OffsetMetres() const { return offset_m_; }
  const ReceiverCounts& Counts() const { return counts_; }

 private:
  void JudgeEpoch(base::TimeNs received_ns);
  bool Believable();

  std::uint8_t node_;
  ReceiverRules rules_;
  ReceiverCounts counts_;
  std::array<std::optional<ReceivedSlot>, 3> axes_;
  std::optional<std::uint8_t> last_counter_;
  std::optional<std::array<double, 3>> offset_m_;
  base::TimeNs accepted_ns_ = base::kNever;
  int in_a_row_ = 0;
  bool good_ = false;
};

}  // namespace adit::publish
