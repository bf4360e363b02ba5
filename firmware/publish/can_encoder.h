// Epoch -> adit-CAN 1.0, scheme canopen: the frames of one cycle, protected, in sending order.
#pragma once

#include <cstdint>

#include "firmware/base/can_frame.h"
#include "firmware/base/fixed_vector.h"
#include "firmware/publish/box_record.h"
#include "firmware/publish/e2e.h"

namespace adit::publish {

/// What one frame of the common shape carries, still without protection.
struct SlotContent {
  std::uint32_t value = 0;  ///< bytes 0-3, little-endian
  std::uint8_t status = 0;  ///< byte 4: bits 0-1 validity, 2-7 age x 4 ms; in INFO the top byte of its number
};

/// The protected frame of `slot` (0 to 14) of the box at `node`. Declines with a frame of length 0 if there
/// is no such slot.
base::CanFrame EncodeSlot(std::uint8_t node, std::uint8_t slot, const SlotContent& content,
                          std::uint8_t counter);

/// Age on the wire, in steps of 4 ms, rounded up (never younger than it is): 63 is 252 ms or more, or
/// unknown.
std::uint8_t WireAge(const Epoch& epoch, base::TimeNs hand_over_ns);

/// The frames of one target. One thread; no heap.
class CanEncoder {
 public:
  /// Block A has eight frames; INFO, heartbeat and EMCY come when they are due.
  static constexpr std::size_t kMaxFrames = 11;
  using Frames = base::FixedVector<base::CanFrame, kMaxFrames>;

  /// `node` 1 to 126 of this target; the next target or body takes node + 2.
  CanEncoder(std::uint8_t node, const BoxIdentity& identity);

  /// Replaces `out`: EMCY when the faults changed, heartbeat every 200 ms (boot-up first), POS_E, POS_N,
  /// POS_H, HEADING, PITCH, ROLL, QUALITY, one number of INFO every 100 ms (nodes up to 0x5F), and STATUS
  /// last: the epoch is complete. Ages are as of `hand_over_ns`; what is too old by then goes out as
  /// INVALID.
  void Encode(const Epoch& epoch, const BoxHealth& health, base::TimeNs hand_over_ns, Frames& out);

  std::uint8_t Node() const { return node_; }

 private:
  void AppendSlot(std::uint8_t slot, Frames& out) const;
  void AppendInfo(Frames& out);
  void AppendService(Frames& out);

  std::uint8_t node_;
  BoxRecord record_;
  base::TimeNs heartbeat_ns_ = base::kNever;
  base::TimeNs info_ns_ = base::kNever;
  std::size_t info_index_ = 0;
  std::uint16_t reported_faults_ = 0;
};

}  // namespace adit::publish
