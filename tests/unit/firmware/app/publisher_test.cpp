// The publisher in real threads, with cameras and a bus that the test commands.
#include "firmware/app/publisher.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "firmware/app/pair_loop.h"
#include "firmware/publish/can_receiver.h"
#include "tests/support/fake_camera.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::kNsPerMs;
using adit::publish::Validity;

constexpr std::uint8_t kNode = 0x20;
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

adit::pipeline::Pipeline PipelineOf(const adit::support::SyntheticRig& rig) {
  auto pipeline = adit::pipeline::Pipeline::Make(
      rig.AsRig(), {adit::support::ModelOf(adit::support::SeedTargetOne())}, {});
  CHECK(!!pipeline);
  return std::move(*pipeline);
}

/// The threads of a box from two fake cameras to a bus. A bar stands 30 m ahead.
struct Line {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  adit::support::SyntheticBar bar =
      adit::support::SyntheticBar::At(adit::support::SeedTargetOne(), {4, 0.5, 30}, {0.9, 0.1, 0.2});
  adit::support::FakeCamera left{adit::base::Side::kLeft, kRateHz, adit::support::DrawBar(rig.left, bar)};
  adit::support::FakeCamera right{adit::base::Side::kRight, kRateHz, adit::support::DrawBar(rig.right, bar)};
  adit::pipeline::Pipeline pipeline = PipelineOf(rig);
  adit::app::PairLoop pairs{pipeline, static_cast<adit::base::DurationNs>(1e9 / kRateHz), kNsPerMs};
  adit::app::CameraLane left_lane{left, adit::base::Side::kLeft, pipeline, pairs.Wake()};
  adit::app::CameraLane right_lane{right, adit::base::Side::kRight, pipeline, pairs.Wake()};
  adit::publish::RegisterMap map{adit::publish::MakeIdentity("1", "0.0.1", 1), {}};
  ListeningBus bus;
  std::unique_ptr<adit::app::Publisher> publisher;

  Line() {
    adit::app::PublisherOptions options;
    options.targets = {0};
    options.period_ns = static_cast<adit::base::DurationNs>(1e9 / kRateHz);
    options.node = kNode;
    const adit::app::PublisherSources sources{pairs.ToPublisher(), left_lane, right_lane};
    publisher = std::make_unique<adit::app::Publisher>(options, sources, map, &bus);
    publisher->Start({});
    pairs.Start({}, {left_lane, right_lane, publisher->Wake(), nullptr});
    left_lane.Start({});
    right_lane.Start({});
    const adit::base::TimeNs start_ns = adit::board::SystemClock().Now() + 20 * kNsPerMs;
    left.Run(start_ns);
    right.Run(start_ns);
  }
  ~Line() {
    pairs.Stop();
    left_lane.Stop();
    right_lane.Stop();
    publisher->Stop();
  }
  static void Sleep(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
};

}  // namespace

TEST_GROUP(Publisher){};

TEST(Publisher, TellsValidPositionsWhileBothCamerasDeliver) {
  Line line;
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
  Line line;
  Line::Sleep(300);
  line.left.Silence(true);
  line.right.Silence(true);
  Line::Sleep(200);
  CHECK(line.left.Delivered() > 5);
  CHECK_EQUAL(line.left.Delivered(), line.left.Released());
  CHECK_EQUAL(line.right.Delivered(), line.right.Released());
}

TEST(Publisher, ASilentCameraIsInvalidWithItsFaultBitAndComesBack) {
  Line line;
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
  Line line;
  line.left.Silence(true);
  line.right.Silence(true);
  Line::Sleep(200);
  line.bus.TakeAll();
  Line::Sleep(500);
  const auto heard = line.bus.TakeAll();
  CHECK(heard.size() >= 6);
  for (const auto& epoch : heard) CHECK(epoch.validity == Validity::kInvalid);
}
