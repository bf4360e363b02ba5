// One camera's way from its driver to blobs: a grab thread and a detect thread, joined by a conveyor of
// frames.
#pragma once

#include <atomic>
#include <thread>

#include "board/sim/board.h"
#include "firmware/app/latency.h"
#include "firmware/base/conveyor.h"
#include "firmware/detect/blob_set.h"
#include "firmware/pipeline/pipeline.h"
#include "hal/camera.h"

namespace adit::app {

/// Settings of the box's hot threads.
struct ThreadOptions {
  int priority = 0;  ///< SCHED_FIFO, 0: ordinary
  int cpu = -1;      ///< -1: any
};

/// What the detect thread hands to the pairing thread.
struct Detection {
  detect::BlobSet blobs;
  std::int64_t ready_monotonic_ns = 0;
};

/// What a lane counts; monotonic. Every frame taken from the driver is shed, or its blob set is, or the
/// pairing thread gets it.
struct LaneHealth {
  hal::CameraHealth camera;
  std::uint64_t frames = 0;          ///< taken from the driver
  std::uint64_t shed_frames = 0;     ///< dropped because the detection was late
  std::uint64_t shed_blob_sets = 0;  ///< dropped because the pairing was late
  bool gone = false;                 ///< the camera has vanished

  std::uint64_t Shed() const { return shed_frames + shed_blob_sets; }
};

/// What a lane works with. All of it outlives the lane.
struct LaneNeighbours {
  hal::Camera& camera;
  pipeline::Pipeline& pipeline;
  board::Wakeup& consumer;  ///< signalled after every blob set
  LatencyTable& latency;
};

/// Owns the two threads and the pools of one camera. Start and Stop belong to the supervisor; Pop and
/// GiveBack to the pairing thread; the rest to any thread.
class CameraLane {
 public:
  CameraLane(base::Side side, const LaneNeighbours& neighbours);
  ~CameraLane();

  void Start(const ThreadOptions& options);
  /// Takes no more frames and ends as a recording does: what was taken is detected and waits for Pop.
  void Stop();

  /// The oldest finished blob set, or nullptr. Give every one back.
  Detection* Pop() { return detections_.Pop(); }
  void GiveBack(Detection* detection) { detections_.GiveBack(detection); }

  /// When the last usable frame came, monotonic; 0 before the first.
  std::int64_t LastFrameMonotonicNs() const {
    // relaxed: a lone time stamp, nothing is published through it.
    return last_frame_monotonic_ns_.load(std::memory_order_relaxed);
  }
  /// No more frames will come, and all are detected: a recording is over, or the lane was stopped.
  bool Ended() const { return ended_.load(std::memory_order_acquire); }
  /// The camera's time stamps are on the box clock, as of the last frame.
  bool ClockLocked() const { return clock_locked_.load(std::memory_order_relaxed); }  // relaxed: a lone flag
  LaneHealth Health() const;

 private:
  // 133 ms at 60 Hz: a receiver that the system woke late delivers so many at once, and they are detected
  // within one period. What waits longer is told as old anyway.
  static constexpr std::size_t kFramesWaiting = 8;
  static constexpr std::size_t kBlobSetsWaiting = 32;  // the pairer may hold 16 of them

  void Grab();
  void Detect();

  base::Side side_;
  hal::Camera& camera_;
  pipeline::Pipeline& pipeline_;
  board::Wakeup& consumer_;
  LatencyTable& latency_;
  board::SystemClock clock_;
  board::Wakeup frame_ready_;
  std::atomic<bool> stop_{false};
  std::thread grab_thread_, detect_thread_;

  /// A frame and when it was taken from the driver.
  struct TakenFrame {
    base::CameraFrame frame;
    std::int64_t taken_monotonic_ns = 0;
  };
  base::Conveyor<TakenFrame, kFramesWaiting> frames_;       // grab -> detect
  base::Conveyor<Detection, kBlobSetsWaiting> detections_;  // detect -> pairing

  std::atomic<std::int64_t> last_frame_monotonic_ns_{0};
  std::atomic<std::uint64_t> frame_count_{0}, shed_frames_{0}, shed_blob_sets_{0};
  std::atomic<bool> gone_{false}, clock_locked_{false}, source_ended_{false}, ended_{false};
};

}  // namespace adit::app
