#include "firmware/publish/can_encoder.h"

#include <algorithm>
#include <vector>

#include "firmware/publish/can_receiver.h"
#include "firmware/publish/signal_table.h"
#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/publish/fixes.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

constexpr std::uint8_t kNode = 0x20;

std::vector<std::uint32_t> Ids(const CanEncoder::Frames& frames) {
  std::vector<std::uint32_t> ids;
  for (const base::CanFrame& frame : frames) ids.push_back(frame.id);
  return ids;
}

const base::CanFrame* Find(const CanEncoder::Frames& frames, std::uint32_t id) {
  const auto* found = std::find_if(frames.begin(), frames.end(), [&](const auto& f) { return f.id == id; });
  return found == frames.end() ? nullptr : found;
}

}  // namespace

TEST_GROUP(CanEncoder) {
  CanEncoder encoder_{kNode, MakeIdentity("4711", "1.2.3", 0xCAFE1234)};
  CanEncoder::Frames frames_;
  base::TimeNs now_ns_ = kExposureNs + 20 * base::kNsPerMs;

  Epoch Tracked() const { return MakeEpoch(&fix_, box_, rules_, now_ns_); }
  void Encode(const Epoch& epoch) { encoder_.Encode(epoch, {}, now_ns_, frames_); }
  void EncodeAfterMs(int ms) {
    now_ns_ += ms * base::kNsPerMs;
    fix_.state.mid_exposure_ns = now_ns_;
    Encode(Tracked());
  }

  georef::GeoFix fix_ = TrackedFix();
  BoxCondition box_ = GoodBox();
  EpochRules rules_;
};

TEST(CanEncoder, SendsBlockAInOrderAndStatusLast) {
  Encode(Tracked());
  EncodeAfterMs(50);
  const std::vector<std::uint32_t> expected{0x1A0, 0x2A0, 0x3A0, 0x220, 0x320, 0x420, 0x520, 0x4A0};
  CHECK(Ids(frames_) == expected);
}

TEST(CanEncoder, AllFramesOfAnEpochCarryItsCounter) {
  Encode(Tracked());
  int protected_frames = 0;
  for (const base::CanFrame& frame : frames_) {
    const auto slot = DecodeSlot(frame, kNode);
    if (!slot) continue;
    ++protected_frames;
    LONGS_EQUAL(0x34, slot->counter);
  }
  LONGS_EQUAL(9, protected_frames);  // block A and the first INFO
}

TEST(CanEncoder, PositionIsTheDifferenceFromTheOrigin) {
  rules_.origin_s_m = {-10, 20, 0};
  Encode(Tracked());
  LONGS_EQUAL(201000, static_cast<std::int32_t>(DecodeSlot(*Find(frames_, 0x1A0), kNode)->value));
  LONGS_EQUAL(2000, static_cast<std::int32_t>(DecodeSlot(*Find(frames_, 0x2A0), kNode)->value));
  LONGS_EQUAL(-33000, static_cast<std::int32_t>(DecodeSlot(*Find(frames_, 0x3A0), kNode)->value));
}

TEST(CanEncoder, ASingleBarHasNoAttitude) {
  Encode(Tracked());
  for (const std::uint32_t id : {0x220U, 0x320U, 0x420U}) {
    const ReceivedSlot slot = *DecodeSlot(*Find(frames_, id), kNode);
    LONGS_EQUAL(INT32_MIN, static_cast<std::int32_t>(slot.value));
    CHECK(slot.validity == Validity::kInvalid);
  }
}

TEST(CanEncoder, AgeIsTakenAtHandOverAndRoundedUp) {
  const Epoch epoch = Tracked();
  LONGS_EQUAL(5, WireAge(epoch, kExposureNs + 20 * base::kNsPerMs));
  LONGS_EQUAL(6, WireAge(epoch, kExposureNs + 20 * base::kNsPerMs + 1));
  LONGS_EQUAL(62, WireAge(epoch, kExposureNs + 248 * base::kNsPerMs));
  LONGS_EQUAL(63, WireAge(epoch, kExposureNs + 248 * base::kNsPerMs + 1));
  LONGS_EQUAL(63, WireAge(epoch, kExposureNs + 3600 * base::kNsPerS));
  LONGS_EQUAL(63, WireAge(Epoch{}, kExposureNs));
}

TEST(CanEncoder, APositionThatGrewOldBeforeHandOverGoesOutInvalid) {
  const Epoch epoch = Tracked();
  encoder_.Encode(epoch, {}, kExposureNs + 101 * base::kNsPerMs, frames_);
  const ReceivedSlot slot = *DecodeSlot(*Find(frames_, 0x1A0), kNode);
  CHECK(slot.validity == Validity::kInvalid);
  LONGS_EQUAL(INT32_MIN, static_cast<std::int32_t>(slot.value));
  LONGS_EQUAL(26, slot.age);
}

TEST(CanEncoder, WithoutAPositionEveryCycleIsStillSent) {
  Encode(MakeEpoch(nullptr, box_, rules_, now_ns_));
  const ReceivedSlot east = *DecodeSlot(*Find(frames_, 0x1A0), kNode);
  CHECK(east.validity == Validity::kInvalid);
  LONGS_EQUAL(INT32_MIN, static_cast<std::int32_t>(east.value));
  LONGS_EQUAL(63, east.age);
  LONGS_EQUAL(0x34, east.counter);
  const ReceivedSlot quality = *DecodeSlot(*Find(frames_, 0x520), kNode);
  LONGS_EQUAL(0xFFFFFFFF, quality.value);
}

TEST(CanEncoder, StatusHoldsStateTargetsFaultsAndLife) {
  box_.faults = kFaultTemperature | kFaultCameraSync;
  box_.targets_used = 99;
  Encode(Tracked());
  const base::CanFrame& status = *Find(frames_, 0x4A0);
  LONGS_EQUAL(0xF2, status.data[0]);  // 15 of 99 targets, TRACK
  LONGS_EQUAL(0x04, status.data[1]);
  LONGS_EQUAL(0x04, status.data[2]);
  LONGS_EQUAL(77, status.data[3]);
}

TEST(CanEncoder, SigmaTooLargeForTheWireStaysAvailable) {
  fix_.covariance_s_m2(2, 2) = 100;
  Encode(Tracked());
  LONGS_EQUAL(65534, DecodeSlot(*Find(frames_, 0x520), kNode)->value >> 16);
}

TEST(CanEncoder, HeartbeatBootsUpOnceAndComesEvery200Ms) {
  std::vector<int> states;
  for (int cycle = 0; cycle < 12; ++cycle) {
    EncodeAfterMs(50);
    if (const auto* frame = Find(frames_, 0x720)) {
      LONGS_EQUAL(1, frame->length);
      states.push_back(frame->data[0]);
    }
  }
  CHECK((states == std::vector<int>{0, 5, 5}));
}

TEST(CanEncoder, EmergencyComesWhenFaultsChangeAndOnlyThen) {
  Encode(Tracked());
  POINTERS_EQUAL(nullptr, Find(frames_, 0x0A0));
  box_.faults = kFaultStorage;
  EncodeAfterMs(50);
  const base::CanFrame* emergency = Find(frames_, 0x0A0);
  CHECK(emergency != nullptr);
  const std::array<std::uint8_t, 8> storage{0x00, 0xFF, 0x80, 0x00, 0x08, 0, 0, 0};
  CHECK(emergency->data == storage);
  EncodeAfterMs(50);
  POINTERS_EQUAL(nullptr, Find(frames_, 0x0A0));
  box_.faults = 0;
  EncodeAfterMs(50);
  emergency = Find(frames_, 0x0A0);
  CHECK(emergency != nullptr);
  CHECK(emergency->data == (std::array<std::uint8_t, 8>{}));
}

TEST(CanEncoder, InfoTellsAllItsNumbersInTurn) {
  rules_.origin_s_m = {-1, 20, 0};
  std::vector<std::uint32_t> numbers(InfoRows().size(), 0xDEAD);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EncodeAfterMs(100);
    const base::CanFrame* info = Find(frames_, 0x6A0);
    CHECK(info != nullptr);
    CHECK(Check(info->data, 0xA208));
    LONGS_EQUAL(i, info->data[0]);
    numbers[i] = info->data[1] + 256U * info->data[2] + 65536U * info->data[3] + 16777216U * info->data[4];
  }
  LONGS_EQUAL(0x0100, numbers[0]);
  LONGS_EQUAL(4711, numbers[1]);
  LONGS_EQUAL(0x010203, numbers[2]);
  LONGS_EQUAL(0xCAFE1234, numbers[3]);
  LONGS_EQUAL(0xFFFFFFFF, numbers[4]);
  LONGS_EQUAL(20, numbers[5]);
  LONGS_EQUAL(now_ns_ / base::kNsPerS, numbers[9]);
}

TEST(CanEncoder, InfoKeepsOutOfReservedIds) {
  CanEncoder high(0x60, {});
  high.Encode(Tracked(), {}, now_ns_, frames_);
  for (const base::CanFrame& frame : frames_) CHECK(frame.id != 0x6E0);
}

TEST(CanEncoder, ASetBackClockDoesNotSilenceTheHeartbeat) {
  Encode(Tracked());
  EncodeAfterMs(-3'600'000);
  CHECK(Find(frames_, 0x720) != nullptr);
}

TEST(CanEncoder, ASlotThatDoesNotExistMakesNoFrame) { LONGS_EQUAL(0, EncodeSlot(kNode, 15, {}, 0).length); }

TEST(CanEncoder, AllocatesNothing) {
  const Epoch epoch = Tracked();
  const std::uint64_t before = support::AllocationCount();
  Encode(epoch);
  LONGS_EQUAL(0, support::AllocationCount() - before);
}

}  // namespace adit::publish
