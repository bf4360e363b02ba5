// A camera that replays a recording.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "drivers/recording/recording.h"
#include "hal/camera.h"
#include "hal/clock.h"

namespace adit::recording {

enum class Pace : std::uint8_t {
  kRecorded,  ///< frames come at the intervals of the recording, later if reading is slower
  kFast,      ///< frames come as fast as they are read and given back
};

struct ReplayOptions {
  std::string folder;
  base::Side side = base::Side::kLeft;
  Pace pace = Pace::kRecorded;
  int width_px = 0, height_px = 0;  ///< expected size; 0: that of the first image
  int buffers = 16;
  /// The box time that the recording's first instant is moved to, all else with it; kNever keeps the recorded
  /// times. At Pace::kRecorded it is also when the first frame comes, by the camera's clock. Two cameras of
  /// one recording must get the same.
  base::TimeNs epoch_ns = base::kNever;
};

/// Replays one side of a recording in order and loses nothing: when no buffer is free it waits. `trigger` is
/// the index of the instant among those of both sides (instants less than half the recording's median period
/// apart are one), so that a frame missing on one side skips a trigger there, as on a real camera. The time
/// of the last packet is that of the end of reading. An image that cannot be read, or is of another size, is
/// delivered with that status and the buffer's old content. Health calls its clock locked: recorded times are
/// of one clock.
class RecordingCamera final : public hal::Camera {
 public:
  /// `clock` dates the delivery and must outlive the camera.
  RecordingCamera(ReplayOptions options, const hal::Clock& clock);

  /// Reads the index and the first image. Declines with file and line.
  base::Result<void> Start() override;
  hal::WaitOutcome Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) override;
  void Release(const base::CameraFrame& frame) override;
  hal::CameraHealth Health() const override;
  std::string Name() const override;
  void Stop() override;

 private:
  using Monotonic = std::chrono::steady_clock;
  struct Buffer {
    StoredImage image;
    std::atomic<bool> taken{false};
  };

  Buffer* TakeFree();
  void Fill(Buffer& buffer, base::CameraFrame& frame);

  ReplayOptions options_;
  const hal::Clock& clock_;
  std::vector<ImageEntry> entries_;
  std::vector<std::uint64_t> triggers_;  ///< of each entry
  base::TimeNs first_ns_ = 0;            ///< the earliest instant of both sides
  Monotonic::time_point started_;
  std::size_t next_ = 0;
  std::vector<std::unique_ptr<Buffer>> pool_;
  std::atomic<std::uint64_t> delivered_{0}, incomplete_{0}, missed_{0};
};

/// The triggers of `entries` as RecordingCamera counts them. Exposed for the tests.
std::vector<std::uint64_t> CountTriggers(const std::vector<ImageEntry>& entries,
                                         const std::vector<ImageEntry>& others);

}  // namespace adit::recording
