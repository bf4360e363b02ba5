// The threads of a box from two fake cameras to a bus. A bar stands 30 m ahead.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <utility>

#include "firmware/app/pair_loop.h"
#include "firmware/app/publisher.h"
#include "tests/support/fake_camera.h"
#include "tests/support/synthetic_bar.h"

namespace adit::app {

inline constexpr std::uint8_t kNode = 0x20;

inline pipeline::Pipeline PipelineOf(const support::SyntheticRig& rig) {
  auto pipeline = pipeline::Pipeline::Make(rig.AsRig(), {support::ModelOf(support::SeedTargetOne())}, {});
  ADIT_REQUIRE(pipeline.operator bool());
  return std::move(*pipeline);
}

/// Counts datagrams.
class CountingPort final : public hal::DatagramPort {
 public:
  void Send(std::span<const char> datagram) override { sent_.fetch_add(datagram.empty() ? 0 : 1); }
  std::uint64_t Sent() const { return sent_.load(); }

 private:
  std::atomic<std::uint64_t> sent_{0};
};

/// Runs from its construction until Stop. `given_bus` outlives it.
struct Line {
  support::SyntheticRig rig = support::ToedInRig();
  support::SyntheticBar bar =
      support::SyntheticBar::At(support::SeedTargetOne(), {4, 0.5, 30}, {0.9, 0.1, 0.2});
  support::FakeCamera left, right;
  pipeline::Pipeline pipeline = PipelineOf(rig);
  LatencyTable latency;
  PairLoop pairs;
  CameraLane left_lane{base::Side::kLeft, {left, pipeline, pairs.Wake(), latency}};
  CameraLane right_lane{base::Side::kRight, {right, pipeline, pairs.Wake(), latency}};
  publish::RegisterMap map{publish::MakeIdentity("1", "0.0.1", 1), {}};
  CountingPort datagrams;
  std::unique_ptr<Publisher> publisher;

  Line(hal::FieldBus& given_bus, double rate_hz)
      : left(base::Side::kLeft, rate_hz, support::DrawBar(rig.left, bar)),
        right(base::Side::kRight, rate_hz, support::DrawBar(rig.right, bar)),
        pairs(pipeline, latency, {PeriodNs(rate_hz), base::kNsPerMs}) {
    PublisherOptions options;
    options.targets = {0};
    options.period_ns = PeriodNs(rate_hz);
    options.node = kNode;
    const PublisherSources sources{pairs.ToPublisher(), left_lane, right_lane, latency};
    publisher = std::make_unique<Publisher>(options, sources, map, PublisherOutlets{&given_bus, &datagrams});
    publisher->Start({});
    pairs.Start({}, {left_lane, right_lane, publisher->Wake(), nullptr});
    left_lane.Start({});
    right_lane.Start({});
    const base::TimeNs start_ns = board::SystemClock().Now() + 20 * base::kNsPerMs;
    left.Run(start_ns);
    right.Run(start_ns);
  }
  ~Line() { Stop(); }

  /// In the order of the box.
  void Stop() {
    publisher->Stop();
    left_lane.Stop();
    right_lane.Stop();
    pairs.Stop();
  }
  static base::DurationNs PeriodNs(double rate_hz) { return static_cast<base::DurationNs>(1e9 / rate_hz); }
  static void Sleep(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
};

}  // namespace adit::app
