// Every frame is accounted for, whatever is too slow; and in the steady state the box's threads touch
// neither the heap nor a lock.
#include <atomic>
#include <functional>
#include <mutex>

#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/app/line.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::app::CameraLane;
using adit::app::Detection;
using adit::app::LaneHealth;
using adit::app::Line;
using adit::app::LoneImages;
using adit::app::Span;

/// Counts what it is given; no heap, no lock.
class CountingBus final : public adit::hal::FieldBus {
 public:
  adit::hal::SendOutcome SendEpoch(std::span<const adit::base::CanFrame>) override {
    epochs_.fetch_add(1);
    return adit::hal::SendOutcome::kSent;
  }
  void Poll(adit::base::TimeNs) override {}
  adit::hal::FieldBusHealth Health() const override { return {}; }
  int Epochs() const { return epochs_.load(); }

 private:
  std::atomic<int> epochs_{0};
};

/// False if it does not come true within a minute, which no machine is too slow for.
bool Eventually(const std::function<bool()>& holds) {
  constexpr int kLooks = 6000, kLookMs = 10;
  for (int i = 0; i < kLooks; ++i) {
    if (holds()) return true;
    Line::Sleep(kLookMs);
  }
  return false;
}

}  // namespace

TEST_GROUP(Accounting) {
  CountingBus bus;

  void CheckSide(const LaneHealth& lane, const LoneImages& lone, std::uint64_t pairs) {
    CHECK_EQUAL(lane.frames, lane.Shed() + pairs + lone.unpaired + lone.at_ends);
  }
};

TEST(Accounting, OverloadShedsAndEveryFrameIsAccountedFor) {
  constexpr double kFarTooFastHz = 20'000;
  Line line(bus, kFarTooFastHz);
  const auto overloaded = [&line] {
    return line.left_lane.Health().shed_frames > 50 && line.right_lane.Health().shed_frames > 50 &&
           line.pairs.Health().pairs > 20;
  };
  CHECK(Eventually(overloaded));
  line.Stop();
  const LaneHealth left = line.left_lane.Health(), right = line.right_lane.Health();
  const adit::app::PairHealth pairs = line.pairs.Health();
  CheckSide(left, pairs.lone[0], pairs.pairs);
  CheckSide(right, pairs.lone[1], pairs.pairs);
  CHECK_EQUAL(line.left.Delivered(), left.frames);
  CHECK_EQUAL(line.left.Delivered(), line.left.Released());
  CHECK_EQUAL(line.right.Delivered(), line.right.Released());
  const auto measured = [&line](Span span) { return line.latency[span].Count(); };
  CHECK_EQUAL(left.frames + right.frames, measured(Span::kPacketToGrab));
  CHECK_EQUAL(left.frames + right.frames - left.shed_frames - right.shed_frames, measured(Span::kDetect));
  CHECK_EQUAL(pairs.pairs, measured(Span::kLocate));
  CHECK_EQUAL(pairs.pairs, measured(Span::kExposureToResult));
}

TEST(Accounting, APairingThatIsTooSlowLosesTheOldestBlobSets) {
  const auto rig = adit::support::ToedInRig();
  const auto bar = adit::support::SyntheticBar::At(adit::support::SeedTargetOne(), {4, 0.5, 30}, {1, 0, 0});
  adit::support::FakeCamera camera(adit::base::Side::kLeft, 1000, adit::support::DrawBar(rig.left, bar));
  adit::pipeline::Pipeline pipeline = adit::app::PipelineOf(rig);
  adit::board::Wakeup consumer;
  adit::app::LatencyTable latency;
  CameraLane lane(adit::base::Side::kLeft, {camera, pipeline, consumer, latency});
  lane.Start({});
  camera.Run(adit::board::SystemClock().Now());
  CHECK(Eventually([&lane] { return lane.Health().shed_blob_sets >= 10; }));
  lane.Stop();
  const LaneHealth health = lane.Health();
  std::uint64_t popped = 0, last_trigger = 0;
  bool ascending = true;
  while (Detection* const detection = lane.Pop()) {
    ascending = ascending && (popped == 0 || detection->blobs.stamp.trigger > last_trigger);
    last_trigger = detection->blobs.stamp.trigger;
    ++popped;
    lane.GiveBack(detection);
  }
  CHECK(ascending);
  CHECK_EQUAL(camera.Delivered() - 1, last_trigger);
  CHECK_EQUAL(health.frames, popped + health.Shed());
}

TEST(Accounting, ThePartsOfTheWayToTheBusAreAllMeasured) {
  Line line(bus, 60);
  CHECK(Eventually([this] { return bus.Epochs() > 10; }));
  line.Stop();
  for (std::size_t span = 0; span < adit::app::kSpans; ++span) {
    CHECK_TEXT(line.latency.At(span).Count() > 0, adit::app::kSpanNames[span].key);
    CHECK_TEXT(line.latency.At(span).Negative() == 0, adit::app::kSpanNames[span].key);
  }
  CHECK(line.datagrams.Sent() > 10);
  CHECK(line.latency[Span::kExposureToBus].MaxNs() >= line.latency[Span::kPacketToBus].MaxNs());
}

TEST(Accounting, TheSteadyStateTouchesNeitherHeapNorLock) {
  if (!adit::support::CountsAllocations()) return;
  Line line(bus, 200);
  CHECK(Eventually([&line] { return line.pairs.Health().located > 20; }));
  const auto before = adit::support::CountsOfAllThreads();
  const std::uint64_t pairs_before = line.pairs.Health().pairs;
  const int epochs_before = bus.Epochs();
  while (line.pairs.Health().pairs < pairs_before + 60 || bus.Epochs() < epochs_before + 5) Line::Sleep(1);
  const auto after = adit::support::CountsOfAllThreads();
  LONGS_EQUAL(before.allocations, after.allocations);
  LONGS_EQUAL(before.locks, after.locks);
}

TEST(Accounting, TheCountOfLocksIsNotAlwaysNought) {
  if (!adit::support::CountsAllocations()) return;
  const auto before = adit::support::CountsOfAllThreads();
  std::mutex mutex;
  mutex.lock();
  mutex.unlock();
  CHECK(adit::support::CountsOfAllThreads().locks > before.locks);
}
