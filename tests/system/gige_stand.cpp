// The Aravis driver against a camera that sends frames which prove themselves. Needs a network namespace of
// its own: cameras answer broadcasts.
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include "tests/system/gige_rig.h"

#include <CppUTest/TestHarness.h>

using adit::base::FrameStatus;
using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::test::GigeRig;
using adit::test::RigOptions;
using adit::test::Seen;
using adit::test::SmallRig;

namespace {

using Frames = std::vector<Seen>;

bool MayUsePacketSockets() {
  const int probe = socket(AF_PACKET, SOCK_RAW, 0);
  if (probe >= 0) close(probe);
  return probe >= 0;
}

/// Packet sockets in this namespace, beside the heading.
int PacketSockets() {
  std::ifstream table("/proc/self/net/packet");
  std::string line;
  int lines = -1;
  while (std::getline(table, line)) ++lines;
  return lines;
}

void Append(Frames& frames, const Frames& more) { frames.insert(frames.end(), more.begin(), more.end()); }

std::size_t Complete(const Frames& frames) {
  std::size_t complete = 0;
  for (const Seen& seen : frames) complete += seen.stamp.status == FrameStatus::kOk ? 1 : 0;
  return complete;
}

/// Complete frames hold what was drawn, in order, and the driver's count goes with the camera's.
void CheckContent(const Frames& frames) {
  const Seen* before = nullptr;
  for (const Seen& seen : frames) {
    if (seen.stamp.status != FrameStatus::kOk) continue;
    CHECK_TEXT(seen.right, "a complete frame has the pixels of one drawing");
    if (before != nullptr) {
      CHECK_TEXT(seen.drawn > before->drawn, "frames come in order");
      LONGS_EQUAL(seen.drawn - before->drawn, seen.stamp.trigger - before->stamp.trigger);
    }
    before = &seen;
  }
}

/// All complete, none left out.
void CheckUnbroken(const Frames& frames, std::size_t count) {
  LONGS_EQUAL(count, frames.size());
  LONGS_EQUAL(count, Complete(frames));
  CheckContent(frames);
  LONGS_EQUAL(count - 1, frames.back().drawn - frames.front().drawn);
  LONGS_EQUAL(count - 1, frames.back().stamp.trigger - frames.front().stamp.trigger);
}

}  // namespace

TEST_GROUP(Gige) {
  RigOptions options = SmallRig();
  std::unique_ptr<GigeRig> rig;
  void Start() {
    rig = std::make_unique<GigeRig>(options);
    if (!rig->Start()) FAIL(rig->Failure().c_str());
  }
  /// False, with a line, where packet sockets are not permitted.
  bool UsePacketSocket() {
    options.driver.packet_socket = true;
    if (MayUsePacketSockets()) return true;
    std::printf("left out: packet sockets are not permitted here\n");
    return false;
  }
  void CheckStream(std::size_t count) {
    const Frames frames = rig->Take(count);
    CheckUnbroken(frames, count);
    const auto& clock = options.camera.trigger;
    for (const Seen& seen : frames) {
      CHECK_EQUAL(clock.EdgeNs(seen.trigger) + kNsPerMs / 2, seen.stamp.mid_exposure_ns);
      CHECK(seen.stamp.last_packet_ns > seen.stamp.mid_exposure_ns);
    }
    const auto health = rig->driver.Health();
    LONGS_EQUAL(count, health.delivered);
    LONGS_EQUAL(0, health.incomplete);
    LONGS_EQUAL(0, health.missed);
    CHECK(health.clock_locked);
  }
  void CheckLoss() {
    rig->camera.Faults().loss = 0.01;
    constexpr std::size_t kCount = 180;
    CheckUnbroken(rig->Take(kCount), kCount);
    const auto health = rig->driver.Health();
    CHECK(health.resent > kCount / 4);  // of 55 packets a frame
    LONGS_EQUAL(0, health.incomplete);
    LONGS_EQUAL(0, health.missed);
  }
  void CheckPlain() { CheckUnbroken(rig->Take(10), 10); }
};

TEST(Gige, StreamsOverAUdpSocket) {
  Start();
  LONGS_EQUAL(0, PacketSockets());
  CheckStream(60);
}

TEST(Gige, StreamsOverAPacketSocket) {
  if (!UsePacketSocket()) return;
  Start();
  LONGS_EQUAL(1, PacketSockets());
  CheckStream(60);
}

TEST(Gige, AsksForLostPacketsOverAUdpSocket) {
  Start();
  CheckLoss();
}

TEST(Gige, AsksForLostPacketsOverAPacketSocket) {
  if (!UsePacketSocket()) return;
  Start();
  CheckLoss();
}

TEST(Gige, ADroppedFrameIsTheOnlyOneMissing) {
  Start();
  Frames frames = rig->Take(10);
  rig->camera.Faults().drop_frames = 1;
  Append(frames, rig->Take(30));
  LONGS_EQUAL(40, frames.size());
  LONGS_EQUAL(40, Complete(frames));
  CheckContent(frames);
  LONGS_EQUAL(40, frames.back().drawn - frames.front().drawn);
  LONGS_EQUAL(1, rig->driver.Health().missed);
  LONGS_EQUAL(0, rig->driver.Health().incomplete);
}

TEST(Gige, ATruncatedFrameIsNeverComplete) {
  Start();
  Frames frames = rig->Take(10);
  rig->camera.Faults().truncate_frames = 2;
  Append(frames, rig->Take(40));
  LONGS_EQUAL(50, frames.size());
  LONGS_EQUAL(48, Complete(frames));
  CheckContent(frames);
  for (const Seen& seen : frames)
    CHECK(seen.stamp.status == FrameStatus::kOk || seen.stamp.status == FrameStatus::kIncomplete);
  LONGS_EQUAL(49, frames.back().drawn - frames.front().drawn);
  LONGS_EQUAL(2, rig->driver.Health().incomplete);
  LONGS_EQUAL(0, rig->driver.Health().missed);
}

TEST(Gige, CountsAndDatesHoldWhenMostPacketsAreLost) {
  Start();
  Frames frames = rig->Take(40);    // every buffer has been used: an old leader stands in it
  rig->camera.Faults().loss = 0.9;  // so many that they are not asked for again
  Append(frames, rig->Take(25));
  rig->camera.Faults().loss = 0;
  Append(frames, rig->Take(40));
  LONGS_EQUAL(105, frames.size());
  CHECK(Complete(frames) < frames.size());
  CHECK(frames.back().stamp.status == FrameStatus::kOk);
  CheckContent(frames);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    CHECK(frames[i].stamp.mid_exposure_ns > frames[i - 1].stamp.mid_exposure_ns);
    CHECK(frames[i].stamp.trigger > frames[i - 1].stamp.trigger);
  }
  const auto health = rig->driver.Health();
  CHECK(health.missed > 0);  // of some, the leader was lost for good
  LONGS_EQUAL(frames.size(), health.delivered);
  LONGS_EQUAL(frames.size() + health.missed - 1, frames.back().stamp.trigger - frames.front().stamp.trigger);
}

TEST(Gige, GoesOnOverTheWrapOfFrameIds) {
  options.camera.first_frame_id = 65530;
  Start();
  CheckStream(30);
}

TEST(Gige, AFramesDateIsItsOwnWhenTheReceiverIsHeldUp) {
  options.receiver_delay_ns = 5 * kNsPerMs;
  Start();
  CheckStream(40);  // more than there are buffers
}

TEST(Gige, Mono12) {
  options.bits = 12;
  Start();
  CheckStream(20);
}

TEST(Gige, SetsExposureTime) {
  options.driver.exposure_us = 1234;
  Start();
  CheckPlain();
  const auto memory = rig->Memory(adit::sim::kRegExposure, 8);
  LONGS_EQUAL(8, memory.size());
  const std::uint64_t bits =
      static_cast<std::uint64_t>(adit::sim::ReadU32(memory, 0)) << 32 | adit::sim::ReadU32(memory, 4);
  DOUBLES_EQUAL(1234, std::bit_cast<double>(bits), 0);
}

TEST(Gige, SetsExposureTimeAbs) {
  options.camera.identity.exposure = adit::sim::ExposureName::kExposureTimeAbs;
  options.driver.exposure_us = 1000;
  Start();
  CheckPlain();
  const auto memory = rig->Memory(adit::sim::kRegExposure, 8);
  LONGS_EQUAL(8, memory.size());
  LONGS_EQUAL(0x408F4000, adit::sim::ReadU32(memory, 0));  // 1000.0
  LONGS_EQUAL(0, adit::sim::ReadU32(memory, 4));
}

TEST(Gige, SetsExposureTimeRaw) {
  options.camera.identity.exposure = adit::sim::ExposureName::kExposureTimeRaw;
  options.driver.exposure_us = 1234;
  Start();
  CheckPlain();
  const auto memory = rig->Memory(adit::sim::kRegExposureRaw, 4);
  LONGS_EQUAL(4, memory.size());
  LONGS_EQUAL(1234, adit::sim::ReadU32(memory, 0));
}

TEST(Gige, ACameraOnItsOwnClockIsMappedToTheBox) {
  options.camera.has_ptp = false;
  options.camera.clock_offset_ns = -3600 * kNsPerS;
  Start();
  const Frames frames = rig->Take(30);
  CheckUnbroken(frames, 30);
  CHECK(!rig->driver.Health().clock_locked);
  for (const Seen& seen : frames) {
    const auto late_ns =
        seen.stamp.mid_exposure_ns - options.camera.trigger.EdgeNs(seen.trigger) - kNsPerMs / 2;
    CHECK(late_ns >= 0 && late_ns < kNsPerS / 2);  // by the transfer, an hour is not left
  }
}

TEST(Gige, ACameraThatIsNotThereIsNamedInOneLine) {
  options.driver.device = "127.0.0.9";
  GigeRig nobody(options);
  const std::int64_t start_ns = adit::linux::MonotonicNs();
  CHECK(!nobody.Start());
  CHECK(adit::linux::MonotonicNs() - start_ns < 10 * kNsPerS);
  STRCMP_CONTAINS("camera 127.0.0.9: is not there: ", nobody.Failure().c_str());
  CHECK(nobody.Failure().find('\n') == std::string::npos);
}

TEST(Gige, WhatACameraCannotDoIsNamedInOneLine) {
  options.driver.trigger_source = "Line7";
  GigeRig other(options);
  CHECK(!other.Start());
  STRCMP_CONTAINS("camera 127.0.0.1: trigger from Line7: ", other.Failure().c_str());
  CHECK(other.Failure().find('\n') == std::string::npos);
}

TEST(Gige, AStalledCameraIsWaitedFor) {
  Start();
  CheckPlain();
  rig->camera.Faults().stall = true;
  adit::base::CameraFrame frame;
  int timeouts = 0;
  for (int i = 0; i < 10 && timeouts < 2; ++i) {
    const auto outcome = rig->Wait(frame);
    CHECK(outcome != adit::hal::WaitOutcome::kGone);
    if (outcome == adit::hal::WaitOutcome::kFrame) rig->driver.Release(frame);
    timeouts = outcome == adit::hal::WaitOutcome::kTimeout ? timeouts + 1 : 0;
  }
  LONGS_EQUAL(2, timeouts);
  rig->camera.Faults().stall = false;
  CheckPlain();
  LONGS_EQUAL(0, rig->driver.Health().reconnects);
}

TEST(Gige, BuffersThatAreKeptAreMissedAndComeBack) {
  options.driver.buffers = 4;
  Start();
  std::vector<adit::base::CameraFrame> kept(4);
  for (auto& frame : kept) {
    for (int i = 0; i < 100 && rig->Wait(frame) != adit::hal::WaitOutcome::kFrame; ++i) {
    }
    CHECK(frame.buffer != nullptr);
  }
  adit::base::CameraFrame none;
  CHECK(rig->Wait(none) == adit::hal::WaitOutcome::kTimeout);
  for (const auto& frame : kept) {
    CHECK(rig->Look(frame).right);  // nobody wrote to it meanwhile
    rig->driver.Release(frame);
  }
  CheckPlain();
  CHECK(rig->driver.Health().starved > 0);
  CHECK(rig->driver.Health().missed > 0);
}

TEST(Gige, ACameraThatVanishedAndReturnedStreamsAgain) {
  Start();
  rig->driver.Stop();  // a second start reconnects as the first would
  CHECK(static_cast<bool>(rig->driver.Start()));
  rig->camera.Faults().loss = 0.02;
  const Frames before = rig->Take(60);
  LONGS_EQUAL(60, before.size());
  const auto earlier = rig->driver.Health();
  CHECK(earlier.resent > 0);
  rig->camera.Faults().loss = 0;
  rig->camera.Faults().vanished = true;
  const std::int64_t until_ns = adit::linux::MonotonicNs() + 2 * kNsPerS;
  adit::base::CameraFrame frame;
  while (adit::linux::MonotonicNs() < until_ns) {
    if (rig->Wait(frame) == adit::hal::WaitOutcome::kFrame) rig->driver.Release(frame);
  }
  rig->camera.Faults().vanished = false;
  const Frames after = rig->Take(30);
  CheckUnbroken(after, 30);
  CHECK(after.front().stamp.trigger > before.back().stamp.trigger);
  const auto health = rig->driver.Health();
  LONGS_EQUAL(1, health.reconnects);
  CHECK(health.resent >= earlier.resent);  // counts are monotonic over connections
  CHECK(health.clock_locked);
}

TEST(Gige, StartsAgainAfterStop) {
  Start();
  const Frames before = rig->Take(10);
  rig->driver.Stop();
  CHECK(static_cast<bool>(rig->driver.Start()));
  const Frames after = rig->Take(10);
  CheckUnbroken(after, 10);
  CHECK(after.front().stamp.trigger > before.back().stamp.trigger);
  LONGS_EQUAL(0, rig->driver.Health().missed);
}
