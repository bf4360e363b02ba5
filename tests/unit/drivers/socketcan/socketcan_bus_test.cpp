#include "drivers/socketcan/socketcan_bus.h"

#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

#include <deque>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace adit::socketcan {
namespace {

// A kernel with one CAN interface: what is written waits in its queue until the test lets it onto the bus.
class FakeSocket final : public CanSocket {
 public:
  WriteOutcome Write(const base::CanFrame& frame) override {
    if (down_) return WriteOutcome::kDown;
    if (queue_.size() >= room_) return WriteOutcome::kFull;
    queue_.push_back(frame);
    return WriteOutcome::kTaken;
  }
  std::optional<ReceivedFrame> Read() override {
    if (received_.empty()) return std::nullopt;
    const ReceivedFrame first = received_.front();
    received_.pop_front();
    return first;
  }
  bool CycleInterface() override {
    ++cycles_;
    if (!may_cycle_) return false;
    queue_.clear();
    down_ = false;
    return true;
  }

  void LetOut(std::size_t count) {
    for (; count > 0 && !queue_.empty(); --count) {
      on_bus_.push_back(queue_.front());
      received_.push_back({.frame = queue_.front(), .own = true});
      queue_.pop_front();
    }
  }
  void LetAllOut() { LetOut(queue_.size()); }
  void Report(std::uint32_t error_class) {
    received_.push_back({.frame = {}, .error = true, .error_class = error_class});
  }

  std::deque<base::CanFrame> queue_;
  std::vector<base::CanFrame> on_bus_;
  std::deque<ReceivedFrame> received_;
  std::size_t room_ = 1000;
  bool down_ = false;
  bool may_cycle_ = true;
  int cycles_ = 0;
};

}  // namespace

TEST_GROUP(SocketCanBus) {
  FakeSocket* kernel_ = new FakeSocket;
  SocketCanBus bus_{std::unique_ptr<CanSocket>(kernel_)};
  base::TimeNs now_ns_ = base::kNsPerS;
  std::uint8_t counter_ = 0;

  std::vector<base::CanFrame> Epoch() {
    ++counter_;
    std::vector<base::CanFrame> frames;
    for (const std::uint32_t id : {0x1A0U, 0x2A0U, 0x4A0U}) {
      frames.push_back({.id = id, .data = {0, 0, 0, 0, 0, 0, 0, counter_}});
    }
    return frames;
  }
  hal::SendOutcome Send() { return bus_.SendEpoch(Epoch()); }
  void PollAfterMs(int ms) {
    now_ns_ += ms * base::kNsPerMs;
    bus_.Poll(now_ns_);
  }
};

TEST(SocketCanBus, AnEpochIsConfirmedByItsEchoes) {
  PollAfterMs(0);
  CHECK(Send() == hal::SendOutcome::kSent);
  kernel_->LetAllOut();
  PollAfterMs(50);
  LONGS_EQUAL(1, bus_.Health().confirmed_epochs);
  LONGS_EQUAL(3, bus_.Health().sent_frames);
  LONGS_EQUAL(0, bus_.Health().dropped_epochs);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, OneEpochIsInFlightAtMost) {
  PollAfterMs(0);
  CHECK(Send() == hal::SendOutcome::kSent);
  kernel_->LetOut(2);
  PollAfterMs(50);
  CHECK(Send() == hal::SendOutcome::kBusy);
  LONGS_EQUAL(1, bus_.Health().dropped_epochs);
  LONGS_EQUAL(1, kernel_->queue_.size());
  kernel_->LetAllOut();
  PollAfterMs(10);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, WithoutEchoItStallsAndEmptiesTheQueueBeforeAnythingNew) {
  PollAfterMs(0);
  (void)Send();
  PollAfterMs(100);
  CHECK_FALSE(bus_.Health().stalled);
  PollAfterMs(1);
  CHECK(bus_.Health().stalled);
  LONGS_EQUAL(1, kernel_->cycles_);
  LONGS_EQUAL(0, kernel_->queue_.size());
  CHECK(Send() == hal::SendOutcome::kSent);
  kernel_->LetAllOut();
  PollAfterMs(50);
  CHECK_FALSE(bus_.Health().stalled);
  LONGS_EQUAL(3, kernel_->on_bus_.size());
  for (const base::CanFrame& frame : kernel_->on_bus_) LONGS_EQUAL(2, frame.data[7]);
}

TEST(SocketCanBus, NothingGoesOutWhileTheQueueCannotBeEmptied) {
  kernel_->may_cycle_ = false;
  PollAfterMs(0);
  (void)Send();
  PollAfterMs(101);
  for (int cycle = 0; cycle < 100; ++cycle) {
    CHECK(Send() == hal::SendOutcome::kDown);
    PollAfterMs(50);
  }
  CHECK(bus_.Health().stalled);
  LONGS_EQUAL(3, kernel_->queue_.size());
  // At once, then after 100, 200, 400, 800, 1600 ms: 5 s hold no more.
  LONGS_EQUAL(6, kernel_->cycles_);
  kernel_->may_cycle_ = true;
  PollAfterMs(5001);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, LateEchoesOfAnEpochGivenUpConfirmNothing) {
  PollAfterMs(0);
  const auto first = Epoch();
  (void)bus_.SendEpoch(first);
  PollAfterMs(101);
  (void)Send();
  for (const base::CanFrame& frame : first) kernel_->received_.push_back({.frame = frame, .own = true});
  PollAfterMs(10);
  LONGS_EQUAL(0, bus_.Health().confirmed_epochs);
  CHECK(Send() == hal::SendOutcome::kBusy);
  kernel_->LetAllOut();
  PollAfterMs(10);
  LONGS_EQUAL(1, bus_.Health().confirmed_epochs);
}

TEST(SocketCanBus, FramesOfOthersConfirmNothing) {
  PollAfterMs(0);
  const auto epoch = Epoch();
  (void)bus_.SendEpoch(epoch);
  for (const base::CanFrame& frame : epoch) kernel_->received_.push_back({.frame = frame, .own = false});
  PollAfterMs(10);
  LONGS_EQUAL(0, bus_.Health().confirmed_epochs);
}

TEST(SocketCanBus, AFullQueueDropsTheEpochAndWhatWasTakenMustComeOutFirst) {
  kernel_->room_ = 2;
  PollAfterMs(0);
  CHECK(Send() == hal::SendOutcome::kDropped);
  LONGS_EQUAL(1, bus_.Health().dropped_epochs);
  LONGS_EQUAL(2, bus_.Health().sent_frames);
  CHECK(Send() == hal::SendOutcome::kBusy);
  kernel_->LetAllOut();
  kernel_->room_ = 1000;
  PollAfterMs(50);
  LONGS_EQUAL(0, bus_.Health().confirmed_epochs);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, AFullQueueWithNothingTakenLeavesNothingInFlight) {
  kernel_->room_ = 0;
  PollAfterMs(0);
  CHECK(Send() == hal::SendOutcome::kDropped);
  kernel_->room_ = 1000;
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, BusOffRestartsWithBackOffAndCounts) {
  PollAfterMs(0);
  (void)Send();
  kernel_->Report(CAN_ERR_BUSOFF);
  PollAfterMs(10);
  LONGS_EQUAL(1, bus_.Health().bus_off);
  LONGS_EQUAL(1, bus_.Health().errors);
  LONGS_EQUAL(1, bus_.Health().dropped_epochs);
  CHECK(Send() == hal::SendOutcome::kDown);
  PollAfterMs(99);
  LONGS_EQUAL(0, kernel_->cycles_);
  PollAfterMs(1);
  LONGS_EQUAL(1, kernel_->cycles_);
  CHECK(Send() == hal::SendOutcome::kSent);
  // Bus-off again before anything was confirmed: twice as long.
  kernel_->Report(CAN_ERR_BUSOFF);
  PollAfterMs(10);
  PollAfterMs(199);
  LONGS_EQUAL(1, kernel_->cycles_);
  PollAfterMs(1);
  LONGS_EQUAL(2, kernel_->cycles_);
  LONGS_EQUAL(2, bus_.Health().bus_off);
}

TEST(SocketCanBus, BackOffEndsAtFiveSecondsAndAConfirmedEpochResetsIt) {
  PollAfterMs(0);
  for (int i = 0; i < 10; ++i) {
    kernel_->Report(CAN_ERR_BUSOFF);
    PollAfterMs(1);
    PollAfterMs(5000);
    LONGS_EQUAL(i + 1, kernel_->cycles_);
  }
  (void)Send();
  kernel_->LetAllOut();
  PollAfterMs(10);
  kernel_->Report(CAN_ERR_BUSOFF);
  PollAfterMs(1);
  PollAfterMs(100);
  LONGS_EQUAL(11, kernel_->cycles_);
}

TEST(SocketCanBus, OtherErrorsAreCountedAndARestartIsNone) {
  PollAfterMs(0);
  kernel_->Report(CAN_ERR_ACK);
  kernel_->Report(CAN_ERR_CRTL);
  kernel_->Report(CAN_ERR_RESTARTED);
  PollAfterMs(1);
  LONGS_EQUAL(2, bus_.Health().errors);
  LONGS_EQUAL(0, bus_.Health().bus_off);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, AnInterfaceTakenDownIsBroughtUpAgain) {
  PollAfterMs(0);
  kernel_->down_ = true;
  CHECK(Send() == hal::SendOutcome::kDown);
  LONGS_EQUAL(1, bus_.Health().dropped_epochs);
  PollAfterMs(100);
  CHECK(Send() == hal::SendOutcome::kSent);
}

TEST(SocketCanBus, MaySendBeforeTheFirstPoll) {
  CHECK(Send() == hal::SendOutcome::kSent);
  PollAfterMs(50);
  CHECK_FALSE(bus_.Health().stalled);
}

TEST(SocketCanBus, ASetBackClockDoesNotHangIt) {
  PollAfterMs(3'600'000);
  (void)Send();
  PollAfterMs(-3'600'000);
  PollAfterMs(101);
  LONGS_EQUAL(1, kernel_->cycles_);
  kernel_->Report(CAN_ERR_BUSOFF);
  PollAfterMs(3'600'000);
  PollAfterMs(-3'600'000);
  PollAfterMs(1);
  LONGS_EQUAL(2, kernel_->cycles_);
}

TEST(SocketCanBus, AnEpochTooLongIsDroppedWhole) {
  PollAfterMs(0);
  const std::vector<base::CanFrame> epoch(SocketCanBus::kMaxEpochFrames + 1);
  CHECK(bus_.SendEpoch(epoch) == hal::SendOutcome::kDropped);
  LONGS_EQUAL(0, kernel_->queue_.size());
}

// On a kernel without CAN the line says so; on one with it, that the interface is missing.
TEST(SocketCanBus, DeclinesAnInterfaceThatIsNotThereInOneLine) {
  auto bus = SocketCanBus::Open("nocan9");
  CHECK_FALSE(static_cast<bool>(bus));
  const int socket = ::socket(PF_CAN, SOCK_RAW, 1);
  if (socket >= 0) ::close(socket);
  STRCMP_CONTAINS(socket >= 0 ? "nocan9: there is no such network interface"
                              : "nocan9: this kernel has no CAN (Address family not supported by protocol): "
                                "load can-raw, or choose the driver candump",
                  bus.error().Line().c_str());
  CHECK_FALSE(static_cast<bool>(SocketCanBus::Open("")));
  CHECK_FALSE(static_cast<bool>(SocketCanBus::Open("a-name-too-long-for-it")));
}

}  // namespace adit::socketcan
