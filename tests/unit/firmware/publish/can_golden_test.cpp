// The golden set of adit-CAN 1.0 (tests/data/can_golden.md): 168 frames of node 0x20, made and decoded by
// other programs.
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "firmware/publish/can_encoder.h"
#include "firmware/publish/can_receiver.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

constexpr std::uint8_t kGoldenNode = 0x20;
constexpr std::uint8_t kBlockASlots = 8;

std::vector<base::CanFrame> GoldenFrames() {
  std::ifstream file("tests/data/can_golden.candump");
  std::vector<base::CanFrame> frames;
  std::string time, channel, text;
  while (file >> time >> channel >> text) {
    base::CanFrame frame;
    const std::size_t mark = text.find('#');
    frame.id = static_cast<std::uint32_t>(std::stoul(text.substr(0, mark), nullptr, 16));
    for (std::size_t i = 0; i < 8; ++i) {
      frame.data[i] = static_cast<std::uint8_t>(std::stoul(text.substr(mark + 1 + 2 * i, 2), nullptr, 16));
    }
    frames.push_back(frame);
  }
  return frames;
}

// A box that has exactly this to say in the slot of `golden`, and nothing else.
Epoch EpochOf(const ReceivedSlot& golden, base::TimeNs now_ns) {
  Epoch epoch;
  epoch.number = golden.counter;
  epoch.validity = golden.validity;
  epoch.age_limit_ns = base::kNsPerS;
  epoch.mid_exposure_ns = now_ns - golden.age * 4 * base::kNsPerMs;
  const std::uint32_t value = golden.value;
  const double number = static_cast<std::int32_t>(value) * 1e-4;
  const bool absent = value == 0x80000000U;
  const double angle_rad = number * std::numbers::pi / 180;
  if (golden.slot < 3 && !absent) {
    epoch.position_s_m = {0, 0, 0};
    (*epoch.position_s_m)[golden.slot] = number;
  }
  epoch.state = static_cast<BoxState>(value & 0xF);
  epoch.targets_used = (value >> 4) & 0xF;
  epoch.faults = (value >> 8) & 0xFFFF;
  epoch.alive = static_cast<std::uint8_t>(value >> 24);
  if (golden.slot == 4 && !absent) epoch.heading_rad = angle_rad;
  if (golden.slot == 5 && !absent) epoch.pitch_rad = angle_rad;
  if (golden.slot == 6 && !absent) epoch.roll_rad = angle_rad;
  if ((value & 0xFFFF) != 0xFFFF) epoch.sigma_horizontal_m = (value & 0xFFFF) * 1e-4;
  if (value >> 16 != 0xFFFF) epoch.sigma_vertical_m = (value >> 16) * 1e-4;
  return epoch;
}

}  // namespace

TEST_GROUP(CanGolden) { std::vector<base::CanFrame> frames_ = GoldenFrames(); };

TEST(CanGolden, HasAllFrames) { LONGS_EQUAL(168, frames_.size()); }

TEST(CanGolden, EveryFrameDecodesAndEncodesBitForBit) {
  for (const base::CanFrame& golden : frames_) {
    const std::optional<ReceivedSlot> slot = DecodeSlot(golden, kGoldenNode);
    CHECK(slot.has_value());
    const auto status = static_cast<std::uint8_t>(static_cast<unsigned>(slot->validity) | (slot->age * 4U));
    CHECK(EncodeSlot(kGoldenNode, slot->slot, {slot->value, status}, slot->counter) == golden);
  }
}

TEST(CanGolden, NoFrameDecodesForAnotherNode) {
  for (const base::CanFrame& golden : frames_) {
    for (std::uint8_t node = 1; node < 127; ++node) {
      if (node != kGoldenNode) CHECK_FALSE(DecodeSlot(golden, node).has_value());
    }
  }
}

// As canmatrix and candied read the first frames.
TEST(CanGolden, TheFirstFramesReadAsOtherProgramsReadThem) {
  const ReceivedSlot east = *DecodeSlot(frames_[0], kGoldenNode);
  LONGS_EQUAL(-152123001, static_cast<std::int32_t>(east.value));
  LONGS_EQUAL(1, static_cast<int>(east.validity));
  LONGS_EQUAL(19, east.age);
  LONGS_EQUAL(250, east.counter);
  const ReceivedSlot north = *DecodeSlot(frames_[1], kGoldenNode);
  LONGS_EQUAL(INT32_MIN, static_cast<std::int32_t>(north.value));
  LONGS_EQUAL(0, static_cast<int>(north.validity));
  const ReceivedSlot status = *DecodeSlot(frames_[3], kGoldenNode);
  LONGS_EQUAL(3, status.slot);
  LONGS_EQUAL(3 + 16 * 1 + 256 * 11265, status.value & 0xFFFFFF);
  LONGS_EQUAL(222, status.value >> 24);
}

TEST(CanGolden, AnEpochWithTheseValuesMakesTheseFrames) {
  constexpr base::TimeNs kNow = 1'700'000'000 * base::kNsPerS;
  int compared = 0;
  for (const base::CanFrame& golden : frames_) {
    const ReceivedSlot slot = *DecodeSlot(golden, kGoldenNode);
    if (slot.slot >= kBlockASlots) continue;
    CanEncoder encoder(kGoldenNode, {});
    CanEncoder::Frames made;
    encoder.Encode(EpochOf(slot, kNow), {}, kNow, made);
    for (const base::CanFrame& frame : made) {
      if (frame.id != golden.id) continue;
      CHECK(frame == golden);
      ++compared;
    }
  }
  LONGS_EQUAL(96, compared);
}

}  // namespace adit::publish
