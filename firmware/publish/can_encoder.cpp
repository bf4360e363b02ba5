#include "firmware/publish/can_encoder.h"

#include <algorithm>
#include <cmath>

#include "firmware/base/require.h"
#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

constexpr base::DurationNs kHeartbeatPeriodNs = 200 * base::kNsPerMs;
constexpr base::DurationNs kInfoPeriodNs = 100 * base::kNsPerMs;
constexpr std::uint8_t kNodeMax = 126;  // node + 1 must be a CANopen node (1-127) too
constexpr std::uint32_t kHeartbeatIdBase = 0x700;
constexpr std::uint32_t kEmergencyIdBase = 0x080;
// CiA 301, 7.2.8.3.2.2: the state in a heartbeat.
constexpr std::uint8_t kBootUp = 0x00;
constexpr std::uint8_t kOperational = 0x05;
// CiA 301, 7.2.7.1: error code "device specific" and bit "manufacturer specific" of the error register.
constexpr std::uint16_t kDeviceSpecific = 0xFF00;
constexpr std::uint8_t kManufacturerSpecific = 0x80;
constexpr std::uint8_t kWireAgeMax = 63;
constexpr base::DurationNs kWireAgeStepNs = 4 * base::kNsPerMs;

constexpr std::uint8_t kBlockA[] = {0, 1, 2, 4, 5, 6, 7};

bool Due(base::TimeNs last_ns, base::DurationNs period_ns, base::TimeNs now_ns) {
  // A clock that was set back must not silence what is periodic.
  return last_ns == base::kNever || now_ns - last_ns >= period_ns || now_ns < last_ns;
}

std::uint32_t PlaceBits(const SignalRow& row, std::int64_t raw) {
  const std::int64_t span = std::int64_t{1} << row.can.bits;
  const std::int64_t low = IsSigned(row.type) ? -span / 2 : 0;
  const std::int64_t high = low + span - 1;
  const auto bits =
      static_cast<std::uint64_t>(std::clamp(raw, low, high)) & static_cast<std::uint64_t>(span - 1);
  return static_cast<std::uint32_t>(bits << row.can.start_bit);
}

struct SlotValue {
  std::uint32_t value = 0;
  bool available = true;
};

SlotValue ValueOf(std::uint8_t slot, const BoxRecord& record) {
  SlotValue result;
  for (const SignalRow& row : Signals()) {
    if (row.can.bits == 0 || row.can.slot != slot) continue;
    const std::int64_t raw = row.raw(record);
    if (row.not_available == raw) result.available = false;
    result.value |= PlaceBits(row, raw);
  }
  return result;
}

}  // namespace

base::CanFrame EncodeSlot(std::uint8_t node, std::uint8_t slot, const SlotContent& content,
                          std::uint8_t counter) {
  base::CanFrame frame;
  const CanSlot* place = FindCanSlot(slot);
  if (place == nullptr) {
    frame.length = 0;
    return frame;
  }
  frame.id = static_cast<std::uint32_t>(place->id_base) + node + place->node_offset;
  for (unsigned i = 0; i < 4; ++i)
    frame.data[i] = static_cast<std::uint8_t>((content.value >> (8 * i)) & 0xFFU);
  frame.data[4] = content.status;
  Protect(frame.data, DataId(node, slot), counter);
  return frame;
}

std::uint8_t WireAge(const Epoch& epoch, base::TimeNs hand_over_ns) {
  const std::optional<base::DurationNs> age_ns = AgeAt(epoch, hand_over_ns);
  if (!age_ns) return kWireAgeMax;
  const base::DurationNs steps = (*age_ns + kWireAgeStepNs - 1) / kWireAgeStepNs;
  return static_cast<std::uint8_t>(std::min<base::DurationNs>(steps, kWireAgeMax));
}

CanEncoder::CanEncoder(std::uint8_t node, const BoxIdentity& identity) : node_(node) {
  ADIT_REQUIRE(node >= 1 && node <= kNodeMax);
  record_.identity = identity;
}

void CanEncoder::Encode(const Epoch& epoch, const BoxHealth& health, base::TimeNs hand_over_ns, Frames& out) {
  out.clear();
  record_.epoch = AsOf(epoch, hand_over_ns);
  record_.health = health;
  record_.now_ns = hand_over_ns;
  AppendService(out);
  for (const std::uint8_t slot : kBlockA) AppendSlot(slot, out);
  AppendInfo(out);
  AppendSlot(kStatusSlot, out);
}

void CanEncoder::AppendSlot(std::uint8_t slot, Frames& out) const {
  const SlotValue value = ValueOf(slot, record_);
  const Validity validity = value.available ? record_.epoch.validity : Validity::kInvalid;
  const unsigned status =
      static_cast<unsigned>(validity) | (static_cast<unsigned>(WireAge(record_.epoch, record_.now_ns)) << 2);
  out.push_back(EncodeSlot(node_, slot, {value.value, static_cast<std::uint8_t>(status)},
                           static_cast<std::uint8_t>(record_.epoch.number & 0xFFU)));
}

void CanEncoder::AppendInfo(Frames& out) {
  if (node_ > kInfoNodeMax || !Due(info_ns_, kInfoPeriodNs, record_.now_ns)) return;
  info_ns_ = record_.now_ns;
  const auto number = static_cast<std::uint32_t>(InfoRows()[info_index_].raw(record_));
  // The number takes bytes 1-4, so INFO has no validity and no age.
  const SlotContent content{static_cast<std::uint32_t>(info_index_) | (number << 8),
                            static_cast<std::uint8_t>(number >> 24)};
  out.push_back(
      EncodeSlot(node_, kInfoSlot, content, static_cast<std::uint8_t>(record_.epoch.number & 0xFFU)));
  info_index_ = (info_index_ + 1) % InfoRows().size();
}

void CanEncoder::AppendService(Frames& out) {
  if (Due(heartbeat_ns_, kHeartbeatPeriodNs, record_.now_ns)) {
    base::CanFrame heartbeat{.id = kHeartbeatIdBase + node_, .length = 1};
    heartbeat.data[0] = heartbeat_ns_ == base::kNever ? kBootUp : kOperational;
    heartbeat_ns_ = record_.now_ns;
    out.push_back(heartbeat);
  }
  const std::uint16_t faults = record_.epoch.faults;
  if (faults == reported_faults_) return;
  reported_faults_ = faults;
  base::CanFrame emergency{.id = kEmergencyIdBase + node_};
  emergency.data[1] = faults != 0 ? kDeviceSpecific >> 8 : 0;
  emergency.data[2] = faults != 0 ? kManufacturerSpecific : 0;
  emergency.data[3] = static_cast<std::uint8_t>(faults & 0xFFU);
  emergency.data[4] = static_cast<std::uint8_t>(faults >> 8);
  out.push_back(emergency);
}

}  // namespace adit::publish
