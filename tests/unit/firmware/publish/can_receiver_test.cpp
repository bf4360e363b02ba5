#include "firmware/publish/can_receiver.h"

#include <array>

#include "firmware/publish/can_encoder.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

constexpr std::uint8_t kSenderNode = 0x20;
constexpr base::DurationNs kCycleNs = 50 * base::kNsPerMs;

struct Sent {
  std::array<std::int32_t, 3> steps{100, 200, 300};
  Validity validity = Validity::kValid;
  unsigned age = 5;
};

}  // namespace

TEST_GROUP(CanReceiver) {
  CanReceiver receiver_{kSenderNode};
  base::TimeNs now_ns_ = base::kNsPerS;
  std::uint8_t counter_ = 250;

  base::CanFrame Axis(std::uint8_t axis, const Sent& sent, std::uint8_t counter) const {
    const auto status = static_cast<std::uint8_t>(static_cast<unsigned>(sent.validity) | (sent.age << 2));
    return EncodeSlot(kSenderNode, axis, {static_cast<std::uint32_t>(sent.steps[axis]), status}, counter);
  }
  void Send(const Sent& sent = {}, int step = 1) {
    now_ns_ += kCycleNs;
    counter_ = static_cast<std::uint8_t>(counter_ + step);
    for (std::uint8_t axis = 0; axis < 3; ++axis) receiver_.Accept(Axis(axis, sent, counter_), now_ns_);
  }
  void SendGood(int epochs) {
    for (int i = 0; i < epochs; ++i) Send();
  }
  bool Good() { return receiver_.Good(now_ns_); }
};

TEST(CanReceiver, TheFirstEpochOnlySetsTheCounterAndThreeGoodOnesFollow) {
  SendGood(3);
  CHECK_FALSE(Good());
  LONGS_EQUAL(2, receiver_.Counts().accepted);
  SendGood(1);
  CHECK(Good());
  const auto offset_m = receiver_.OffsetMetres();
  DOUBLES_EQUAL(0.02, (*offset_m)[1], 1e-12);
}

TEST(CanReceiver, TheCounterMayWrapAndLoseTwoEpochs) {
  SendGood(4);
  for (const int step : {1, 2, 3, 3, 3}) Send({}, step);
  CHECK(Good());
  LONGS_EQUAL(8, receiver_.Counts().accepted);
}

TEST(CanReceiver, AStandingCounterIsRefused) {
  SendGood(4);
  for (int i = 0; i < 4; ++i) Send({}, 0);
  CHECK_FALSE(Good());
  LONGS_EQUAL(5, receiver_.Counts().out_of_step);
}

TEST(CanReceiver, AJumpOfFourIsRefusedAndTheNextStepCountsAgain) {
  SendGood(4);
  const auto before = receiver_.Counts().accepted;
  Send({}, 4);
  LONGS_EQUAL(before, receiver_.Counts().accepted);
  Send();
  LONGS_EQUAL(before + 1, receiver_.Counts().accepted);
  CHECK(Good());
}

TEST(CanReceiver, OnlyValidMovesAMachine) {
  SendGood(4);
  for (const Validity validity : {Validity::kInvalid, Validity::kDegraded, Validity::kSimulated}) {
    const auto before = receiver_.Counts().accepted;
    Sent sent;
    sent.validity = validity;
    Send(sent);
    LONGS_EQUAL(before, receiver_.Counts().accepted);
  }
  LONGS_EQUAL(3, receiver_.Counts().not_valid);
}

TEST(CanReceiver, ATestStandMayAcceptSimulation) {
  ReceiverRules rules;
  rules.accept_simulated = true;
  receiver_ = CanReceiver(kSenderNode, rules);
  Sent sent;
  sent.validity = Validity::kSimulated;
  for (int i = 0; i < 4; ++i) Send(sent);
  CHECK(Good());
}

TEST(CanReceiver, AValueThatIsNotAvailableIsRefusedHoweverValidItClaimsToBe) {
  Sent sent;
  sent.steps[1] = INT32_MIN;
  for (int i = 0; i < 5; ++i) Send(sent);
  CHECK_FALSE(Good());
  LONGS_EQUAL(0, receiver_.Counts().accepted);
}

TEST(CanReceiver, AgeUpTo100MsPasses) {
  Send();
  Sent sent;
  sent.age = 25;
  Send(sent);
  LONGS_EQUAL(1, receiver_.Counts().accepted);
  sent.age = 26;
  Send(sent);
  sent.age = 63;
  Send(sent);
  LONGS_EQUAL(1, receiver_.Counts().accepted);
  LONGS_EQUAL(2, receiver_.Counts().too_old);
}

TEST(CanReceiver, AFrameMissingFromAnEpochMakesNoPosition) {
  SendGood(4);
  const auto before = receiver_.Counts().epochs;
  const auto next = static_cast<std::uint8_t>(counter_ + 1);
  receiver_.Accept(Axis(0, {}, next), now_ns_);
  receiver_.Accept(Axis(1, {}, next), now_ns_);
  receiver_.Accept(Axis(2, {}, static_cast<std::uint8_t>(next + 1)), now_ns_);
  LONGS_EQUAL(before, receiver_.Counts().epochs);
}

TEST(CanReceiver, ADamagedFrameIsCountedAndItsEpochIsNotUsed) {
  SendGood(4);
  const auto before = receiver_.Counts().epochs;
  const auto next = static_cast<std::uint8_t>(counter_ + 1);
  receiver_.Accept(Axis(0, {}, next), now_ns_);
  base::CanFrame damaged = Axis(1, {}, next);
  damaged.data[2] ^= 0x10;
  receiver_.Accept(damaged, now_ns_);
  receiver_.Accept(Axis(2, {}, next), now_ns_);
  LONGS_EQUAL(1, receiver_.Counts().crc_errors);
  LONGS_EQUAL(before, receiver_.Counts().epochs);
}

TEST(CanReceiver, SafeReactionComes150MsAfterTheLastAcceptedEpoch) {
  SendGood(4);
  CHECK(receiver_.Good(now_ns_ + 150 * base::kNsPerMs));
  CHECK_FALSE(receiver_.Good(now_ns_ + 150 * base::kNsPerMs + 1));
}

TEST(CanReceiver, ComesBackAfterThreeGoodEpochsInARow) {
  SendGood(4);
  now_ns_ += base::kNsPerS;
  CHECK_FALSE(Good());
  SendGood(2);
  Send({.validity = Validity::kDegraded});
  SendGood(2);
  CHECK_FALSE(Good());
  SendGood(1);
  CHECK(Good());
}

TEST(CanReceiver, AGapThatNobodyLookedAtStillEndsWhatWasGood) {
  SendGood(4);
  now_ns_ += base::kNsPerS;
  Send();
  CHECK_FALSE(Good());
}

TEST(CanReceiver, OneBadEpochDoesNotStopTheMachine) {
  SendGood(4);
  Send({.validity = Validity::kDegraded});
  CHECK(Good());
  Send();
  CHECK(Good());
}

TEST(CanReceiver, PassesOverForeignShortAndExtendedFrames) {
  SendGood(4);
  const auto before = receiver_.Counts();
  base::CanFrame foreign = EncodeSlot(0x22, 0, {}, counter_);
  receiver_.Accept(foreign, now_ns_);
  base::CanFrame extended = Axis(0, {}, counter_);
  extended.extended = true;
  receiver_.Accept(extended, now_ns_);
  LONGS_EQUAL(before.frames, receiver_.Counts().frames);
  base::CanFrame brief = Axis(0, {}, counter_);
  brief.length = 7;
  receiver_.Accept(brief, now_ns_);
  LONGS_EQUAL(before.crc_errors + 1, receiver_.Counts().crc_errors);
}

}  // namespace adit::publish
