// The publisher in real threads, with cameras and a bus that the test commands.
#include "firmware/app/publisher.h"

#include <mutex>
#include <utility>
#include <vector>

#include "firmware/publish/can_receiver.h"
#include "tests/unit/firmware/app/line.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::app::Line;
using adit::publish::Validity;

using adit::app::kNode;
constexpr double kRateHz = 60;

/// Keeps every epoch with the time of its hand-over.
class ListeningBus final : public adit::hal::FieldBus {
 public:
  struct Heard {
    std::int64_t monotonic_ns;
    Validity validity;
    std::uint16_t faults;
    std::uint8_t counter;
  };

  adit::hal::SendOutcome SendEpoch(std::span<const adit::base::CanFrame> frames) override {
    Heard heard{adit::board::MonotonicNs(), Validity::kInvalid, 0, 0};
    for (const auto& frame : frames) {
      const auto slot = adit::publish::DecodeSlot(frame, kNode);
      if (slot && slot->slot == 0) heard.validity = slot->validity;
      if (slot && slot->slot == 3) {
        heard.faults = static_cast<std::uint16_t>((slot->value >> 8) & 0xFFFF);
        heard.counter = slot->counter;
      }
    }
    const std::lock_guard lock(mutex_);
    heard_.push_back(heard);
    return adit::hal::SendOutcome::kSent;
  }
  void Poll(adit::base::TimeNs) override {}
  adit::hal::FieldBusHealth Health() const override { return {}; }

  std::vector<Heard> TakeAll() {
    const std::lock_guard lock(mutex_);
    return std::exchange(heard_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Heard> heard_;
};

struct Heard {
  ListeningBus bus;
};
struct HeardLine : Heard, Line {
  HeardLine() : Line(bus, kRateHz) {}
};

}  // namespace

TEST_GROUP(Publisher){};

TEST(Publisher, TellsValidPositionsWhileBothCamerasDeliver) {
  HeardLine line;
  Line::Sleep(600);
  const auto heard = line.bus.TakeAll();
  CHECK(heard.size() >= 8);
  CHECK(heard.back().validity == Validity::kValid);
  LONGS_EQUAL(adit::publish::kFaultGeoreference, heard.back().faults);
  for (std::size_t i = 1; i < heard.size(); ++i) {
    LONGS_EQUAL(static_cast<std::uint8_t>(heard[i - 1].counter + 1), heard[i].counter);
  }
}

TEST(Publisher, GivesEveryFrameBackToItsCamera) {
  HeardLine line;
  Line::Sleep(300);
  line.left.Silence(true);
  line.right.Silence(true);
  Line::Sleep(200);
  CHECK(line.left.Delivered() > 5);
  CHECK_EQUAL(line.left.Delivered(), line.left.Released());
  CHECK_EQUAL(line.right.Delivered(), line.right.Released());
}

TEST(Publisher, ASilentCameraIsInvalidWithItsFaultBitAndComesBack) {
  HeardLine line;
  Line::Sleep(400);
  line.bus.TakeAll();
  line.right.Silence(true);
  Line::Sleep(300);
  const auto silent = line.bus.TakeAll();
  CHECK(!silent.empty());
  CHECK(silent.back().validity == Validity::kInvalid);
  CHECK((silent.back().faults & adit::publish::kFaultCameraB) != 0);
  CHECK((silent.back().faults & adit::publish::kFaultCameraA) == 0);
  line.right.Silence(false);
  Line::Sleep(400);
  const auto back = line.bus.TakeAll();
  CHECK(!back.empty());
  CHECK(back.back().validity == Validity::kValid);
  LONGS_EQUAL(adit::publish::kFaultGeoreference, back.back().faults);
}

TEST(Publisher, KeepsTellingWithoutAnyImage) {
  HeardLine line;
  line.left.Silence(true);
  line.right.Silence(true);
  Line::Sleep(200);
  line.bus.TakeAll();
  Line::Sleep(500);
  const auto heard = line.bus.TakeAll();
  CHECK(heard.size() >= 6);
  for (const auto& epoch : heard) CHECK(epoch.validity == Validity::kInvalid);
}
