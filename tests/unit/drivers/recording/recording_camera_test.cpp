#include "drivers/recording/recording_camera.h"

#include <filesystem>

#include "tests/support/scratch_folder.h"

#include <CppUTest/TestHarness.h>

using adit::base::CameraFrame;
using adit::base::FrameStatus;
using adit::base::kNsPerMs;
using adit::base::Side;
using adit::base::TimeNs;
using adit::hal::WaitOutcome;
using adit::recording::CountTriggers;
using adit::recording::ImageEntry;
using adit::recording::Pace;
using adit::recording::RecordingCamera;
using adit::recording::RecordingWriter;
using adit::recording::ReplayOptions;
using adit::tests::ScratchFolder;

namespace {

constexpr int kFrameWidthPx = 8, kFrameHeightPx = 4;
constexpr TimeNs kFirstNs = 1'700'000'000'000'000'000, kPeriodNs = 20 * kNsPerMs;
constexpr adit::base::DurationNs kShortNs = 1 * kNsPerMs, kLongNs = 2'000 * kNsPerMs;

class FixedClock final : public adit::hal::Clock {
 public:
  TimeNs Now() const override { return 42; }
};

/// Frames 0, 1, 3, 4 on the left (2 is lost), 0 to 4 on the right; each pixel is the frame's number.
struct Replayed {
  ScratchFolder scratch;
  FixedClock clock;
  ReplayOptions options;

  Replayed() {
    options.folder = scratch / "rec";
    options.pace = Pace::kFast;
    auto writer = RecordingWriter::Create(options.folder, "", "");
    for (int i = 0; i < 5; ++i) {
      const std::vector<std::uint8_t> pixels(kFrameWidthPx * kFrameHeightPx, static_cast<std::uint8_t>(i));
      for (const Side side : {Side::kLeft, Side::kRight}) {
        if (i == 2 && side == Side::kLeft) continue;
        CHECK_TRUE(static_cast<bool>(
            writer->Write(side, kFirstNs + i * kPeriodNs,
                          {pixels.data(), kFrameWidthPx, kFrameHeightPx, kFrameWidthPx, 8})));
      }
    }
    CHECK_TRUE(static_cast<bool>(writer->Finish()));
  }
};

std::vector<ImageEntry> At(std::initializer_list<TimeNs> times_ns) {
  std::vector<ImageEntry> entries;
  for (const TimeNs time_ns : times_ns) entries.push_back({time_ns, ""});
  return entries;
}

}  // namespace

TEST_GROUP(RecordingCamera){};

TEST(RecordingCamera, DeliversAllFramesInOrderWithTheirTimesAndTriggers) {
  const Replayed rig;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  for (const std::uint64_t trigger : {0U, 1U, 3U, 4U}) {
    CameraFrame frame;
    CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
    LONGS_EQUAL(trigger, frame.stamp.trigger);
    LONGLONGS_EQUAL(kFirstNs + static_cast<TimeNs>(trigger) * kPeriodNs, frame.stamp.mid_exposure_ns);
    LONGS_EQUAL(42, frame.stamp.last_packet_ns);
    CHECK_TRUE(frame.stamp.status == FrameStatus::kOk);
    LONGS_EQUAL(trigger, frame.image.Row(kFrameHeightPx - 1)[kFrameWidthPx - 1]);
    camera.Release(frame);
  }
  CameraFrame frame;
  CHECK_TRUE(camera.Wait(kShortNs, frame) == WaitOutcome::kEnd);
  CHECK_TRUE(camera.Wait(kShortNs, frame) == WaitOutcome::kEnd);
  LONGS_EQUAL(4, camera.Health().delivered);
  LONGS_EQUAL(1, camera.Health().missed);
}

TEST(RecordingCamera, MovesTimesToTheEpochThatItIsGiven) {
  Replayed rig;
  rig.options.side = Side::kRight;
  rig.options.epoch_ns = 5'000;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  CameraFrame frame;
  for (int i = 0; i < 3; ++i) {
    CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
    LONGLONGS_EQUAL(5'000 + i * kPeriodNs, frame.stamp.mid_exposure_ns);
    CHECK_TRUE(frame.stamp.side == Side::kRight);
    camera.Release(frame);
  }
}

TEST(RecordingCamera, TheFirstFrameComesAtTheEpoch) {
  Replayed rig;
  rig.options.pace = adit::recording::Pace::kRecorded;
  rig.options.epoch_ns = rig.clock.Now() + 100 * adit::base::kNsPerMs;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  CameraFrame frame;
  CHECK_TRUE(camera.Wait(kShortNs, frame) == WaitOutcome::kTimeout);
  CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
  LONGLONGS_EQUAL(rig.options.epoch_ns, frame.stamp.mid_exposure_ns);
  camera.Release(frame);
}

TEST(RecordingCamera, WaitsForABufferInsteadOfLosingAFrame) {
  Replayed rig;
  rig.options.buffers = 2;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  CameraFrame first, second, third;
  CHECK_TRUE(camera.Wait(kLongNs, first) == WaitOutcome::kFrame);
  CHECK_TRUE(camera.Wait(kLongNs, second) == WaitOutcome::kFrame);
  CHECK_TRUE(camera.Wait(kShortNs, third) == WaitOutcome::kTimeout);
  LONGS_EQUAL(0, first.image.Row(0)[0]);  // untouched while it is out
  camera.Release(second);
  CHECK_TRUE(camera.Wait(kLongNs, third) == WaitOutcome::kFrame);
  LONGS_EQUAL(3, third.image.Row(0)[0]);
}

TEST(RecordingCamera, KeepsTheRecordedPace) {
  Replayed rig;
  rig.options.pace = Pace::kRecorded;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  const auto started = std::chrono::steady_clock::now();
  CameraFrame frame;
  CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
  camera.Release(frame);
  CHECK_TRUE(camera.Wait(0, frame) == WaitOutcome::kTimeout);
  for (int i = 1; i < 4; ++i) {
    CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
    camera.Release(frame);
  }
  const auto took = std::chrono::steady_clock::now() - started;
  // The last frame was recorded four periods after the first.
  CHECK_TRUE(took >= std::chrono::nanoseconds(4 * kPeriodNs) - std::chrono::milliseconds(5));
}

TEST(RecordingCamera, DeliversWhatCannotBeReadAsIncompleteAndGoesOn) {
  const Replayed rig;
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  const auto second =
      std::filesystem::path("rec/cam0/data") / (std::to_string(kFirstNs + kPeriodNs) + ".png");
  rig.scratch.Write(second.string(), "not an image");
  CameraFrame frame;
  const FrameStatus expected[] = {FrameStatus::kOk, FrameStatus::kIncomplete, FrameStatus::kOk};
  for (const FrameStatus status : expected) {
    CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
    CHECK_TRUE(frame.stamp.status == status);
    LONGS_EQUAL(kFrameWidthPx, frame.image.width_px);
    camera.Release(frame);
  }
  LONGS_EQUAL(1, camera.Health().incomplete);
}

TEST(RecordingCamera, DeliversTwelveBitsAsTheDetectionTakesThem) {
  Replayed rig;
  rig.options.folder = rig.scratch / "twelve";
  auto writer = RecordingWriter::Create(rig.options.folder, "", "");
  std::vector<std::uint16_t> pixels(kFrameWidthPx * kFrameHeightPx);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint16_t>(4095 - 100 * i);
  const adit::base::ImageView view{reinterpret_cast<const std::uint8_t*>(pixels.data()), kFrameWidthPx,
                                   kFrameHeightPx, 2 * kFrameWidthPx, 12};
  for (const Side side : {Side::kLeft, Side::kRight})
    CHECK_TRUE(static_cast<bool>(writer->Write(side, kFirstNs, view)));
  CHECK_TRUE(static_cast<bool>(writer->Finish()));
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_TRUE(static_cast<bool>(camera.Start()));
  CameraFrame frame;
  CHECK_TRUE(camera.Wait(kLongNs, frame) == WaitOutcome::kFrame);
  CHECK_TRUE(frame.stamp.status == FrameStatus::kOk);
  LONGS_EQUAL(12, frame.image.bits);
  MEMCMP_EQUAL(pixels.data(), frame.image.data, pixels.size() * sizeof(std::uint16_t));
  camera.Release(frame);
}

TEST(RecordingCamera, RefusesARecordingOfAnotherSize) {
  Replayed rig;
  rig.options.width_px = 1400, rig.options.height_px = 1024;
  RecordingCamera camera(rig.options, rig.clock);
  const auto started = camera.Start();
  CHECK_FALSE(static_cast<bool>(started));
  STRCMP_CONTAINS("is 8 x 4 px; the rig's camera has 1400 x 1024", started.error().Line().c_str());
}

TEST(RecordingCamera, RefusesAFolderThatIsNoRecording) {
  Replayed rig;
  rig.options.folder = rig.scratch / "nowhere";
  RecordingCamera camera(rig.options, rig.clock);
  CHECK_FALSE(static_cast<bool>(camera.Start()));
}

TEST(RecordingCamera, CountsTheSameTriggersOnBothSidesWhicheverLostFrames) {
  const auto left = At({1000, 2001, 4002, 5000});
  const auto right = At({1003, 2000, 3000, 5001, 6000});
  CHECK_TRUE(CountTriggers(left, right) == (std::vector<std::uint64_t>{0, 1, 3, 4}));
  CHECK_TRUE(CountTriggers(right, left) == (std::vector<std::uint64_t>{0, 1, 2, 4, 5}));
}

TEST(RecordingCamera, CountsTriggersOfASingleFrame) {
  CHECK_TRUE(CountTriggers(At({7}), At({7})) == std::vector<std::uint64_t>{0});
  CHECK_TRUE(CountTriggers(At({7}), At({5, 6, 7})) == std::vector<std::uint64_t>{2});
}
