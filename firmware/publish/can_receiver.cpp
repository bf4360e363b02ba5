#include "firmware/publish/can_receiver.h"

#include <algorithm>

#include "firmware/publish/e2e.h"
#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

constexpr base::DurationNs kAgeStepNs = 4 * base::kNsPerMs;
constexpr std::uint8_t kAgeUnknown = 63;
constexpr unsigned kCounterStepMax = 3;

}  // namespace

std::optional<std::uint8_t> SlotOf(const base::CanFrame& frame, std::uint8_t node) {
  if (frame.extended) return std::nullopt;
  const auto slots = CanSlots();
  const auto slot = std::ranges::find_if(slots, [&](const CanSlot& candidate) {
    return frame.id == static_cast<std::uint32_t>(candidate.id_base) + node + candidate.node_offset;
  });
  if (slot == slots.end()) return std::nullopt;
  return slot->slot;
}

std::optional<ReceivedSlot> DecodeSlot(const base::CanFrame& frame, std::uint8_t node) {
  const std::optional<std::uint8_t> slot = SlotOf(frame, node);
  if (!slot || frame.length != frame.data.size() || !Check(frame.data, DataId(node, *slot))) {
    return std::nullopt;
  }
  ReceivedSlot received;
  received.slot = *slot;
  for (unsigned i = 0; i < 4; ++i) received.value |= static_cast<std::uint32_t>(frame.data[i]) << (8 * i);
  received.validity = static_cast<Validity>(frame.data[4] & 0x03U);
  received.age = static_cast<std::uint8_t>(frame.data[4] >> 2);
  received.counter = frame.data[kE2eCounterByte];
  return received;
}

void CanReceiver::Accept(const base::CanFrame& frame, base::TimeNs received_ns) {
  const std::optional<std::uint8_t> slot = SlotOf(frame, node_);
  if (!slot) return;
  ++counts_.frames;
  const std::optional<ReceivedSlot> received = DecodeSlot(frame, node_);
  if (!received) {
    ++counts_.crc_errors;
    return;
  }
  if (received->slot >= axes_.size()) return;
  axes_[received->slot] = received;
  const bool complete = std::ranges::all_of(
      axes_, [&](const auto& axis) { return axis && axis->counter == received->counter; });
  if (!complete) return;
  JudgeEpoch(received_ns);
  // Each epoch counts once, and a frame that comes twice does not make another.
  axes_ = {};
}

void CanReceiver::JudgeEpoch(base::TimeNs received_ns) {
  ++counts_.epochs;
  // A gap ends what was good before it, also if nobody asked during the gap.
  Good(received_ns);
  const std::uint8_t counter = axes_[0]->counter;
  const unsigned step = last_counter_ ? (counter - *last_counter_) & 0xFFU : 0U;
  const bool in_step = step >= 1 && step <= kCounterStepMax;
  last_counter_ = counter;
  if (!in_step) {
    ++counts_.out_of_step;
    in_a_row_ = 0;
    return;
  }
  if (!Believable()) {
    in_a_row_ = 0;
    return;
  }
  ++counts_.accepted;
  accepted_ns_ = received_ns;
  in_a_row_ = std::min(in_a_row_ + 1, rules_.good_epochs);
  if (in_a_row_ >= rules_.good_epochs) good_ = true;
  std::array<double, 3> offset_m{};
  for (std::size_t i = 0; i < 3; ++i) offset_m[i] = static_cast<std::int32_t>(axes_[i]->value) * kStepM;
  offset_m_ = offset_m;
}

// Counts why not.
bool CanReceiver::Believable() {
  const bool valid = std::ranges::all_of(axes_, [&](const auto& axis) {
    const bool simulated = rules_.accept_simulated && axis->validity == Validity::kSimulated;
    const bool available = axis->value != static_cast<std::uint32_t>(kNoI32);
    return available && (simulated || axis->validity == Validity::kValid);
  });
  const bool fresh = std::ranges::all_of(axes_, [&](const auto& axis) {
    return axis->age != kAgeUnknown && axis->age * kAgeStepNs <= rules_.age_limit_ns;
  });
  if (!valid) ++counts_.not_valid;
  if (valid && !fresh) ++counts_.too_old;
  return valid && fresh;
}

bool CanReceiver::Good(base::TimeNs now_ns) {
  if (good_ && now_ns - accepted_ns_ > rules_.timeout_ns) {
    good_ = false;
    in_a_row_ = 0;
  }
  return good_;
}

}  // namespace adit::publish
