// One camera's way from its driver to blobs: a grab thread and a detect thread, joined by a conveyor of
// frames.
#pragma once

#include <atomic>
#include <thread>

#include "board/sim/board.h"
#include "firmware/base/conveyor.h"
#include "firmware/base/histogram.h"
#include "firmware/detect/blob_set.h"
#include "firmware/pipeline/pipeline.h"
#include "hal/camera.h"

namespace adit::app {

/// Settings of the box's hot threads.
struct ThreadOptions {
  int priority = 0;  ///< SCHED_FIFO, 0: ordinary
  int cpu = -1;      ///< -1: any
};

/// What a lane counts; monotonic.
struct LaneHealth {
  hal::CameraHealth camera;
  std::uint64_t frames = 0;          ///< taken from the driver
  std::uint64_t shed_frames = 0;     ///< dropped because the detection was late
  std::uint64_t shed_blob_sets = 0;  ///< dropped because the pairing was late
  bool gone = false;                 ///< the camera has vanished
};

/// Owns the two threads and the pools of one camera. Start and Stop belong to the supervisor; Pop and
/// GiveBack to the pairing thread; the rest to any thread.
class CameraLane {
 public:
  /// `camera`, `pipeline` and `consumer` outlive the lane. `consumer` is signalled after every blob set.
  CameraLane(hal::Camera& camera, base::Side side, pipeline::Pipeline& pipeline, board::Wakeup& consumer);
  ~CameraLane();

  void Start(const ThreadOptions& options);
  void Stop();

  /// The oldest finished blob set, or nullptr. Give every one back.
  detect::BlobSet* Pop() { return blobs_.Pop(); }
  void GiveBack(detect::BlobSet* blobs) { blobs_.GiveBack(blobs); }

  /// When the last usable frame came, monotonic; 0 before the first.
  std::int64_t LastFrameMonotonicNs() const {
    // relaxed: a lone time stamp, nothing is published through it.
    return last_frame_monotonic_ns_.load(std::memory_order_relaxed);
  }
  /// A recording is over and all its frames are detected.
  bool Ended() const { return ended_.load(std::memory_order_acquire); }
  /// The camera's time stamps are on the box clock, as of the last frame.
  bool ClockLocked() const { return clock_locked_.load(std::memory_order_relaxed); }  // relaxed: a lone flag
  LaneHealth Health() const;
  const base::DurationHistogram& DetectTime() const { return detect_time_; }

 private:
  static constexpr std::size_t kFramesWaiting = 4;     // 67 ms at 60 Hz: older images are not worth the wait
  static constexpr std::size_t kBlobSetsWaiting = 32;  // the pairer may hold 16 of them

  void Grab();
  void Detect();

  hal::Camera& camera_;
  base::Side side_;
  pipeline::Pipeline& pipeline_;
  board::Wakeup& consumer_;
  board::Wakeup frame_ready_;
  std::atomic<bool> stop_{false};
  std::thread grab_thread_, detect_thread_;

  base::Conveyor<base::CameraFrame, kFramesWaiting> frames_;  // grab -> detect
  base::Conveyor<detect::BlobSet, kBlobSetsWaiting> blobs_;   // detect -> pairing

  std::atomic<std::int64_t> last_frame_monotonic_ns_{0};
  std::atomic<std::uint64_t> frame_count_{0}, shed_frames_{0}, shed_blob_sets_{0};
  std::atomic<bool> gone_{false}, clock_locked_{false}, source_ended_{false}, ended_{false};
  base::DurationHistogram detect_time_;
};

}  // namespace adit::app
