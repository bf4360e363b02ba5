#include "firmware/app/camera_lane.h"

namespace adit::app {
namespace {

constexpr base::DurationNs kWaitFrameNs = 20 * base::kNsPerMs;  // how soon a stop or a silence is noticed
constexpr base::DurationNs kWaitWorkNs = 100 * base::kNsPerMs;  // bounded, so that Stop always ends

}  // namespace

CameraLane::CameraLane(hal::Camera& camera, base::Side side, pipeline::Pipeline& pipeline,
                       board::Wakeup& consumer)
    : camera_(camera), side_(side), pipeline_(pipeline), consumer_(consumer) {}

CameraLane::~CameraLane() { Stop(); }

void CameraLane::Start(const ThreadOptions& options) {
  const std::string name = side_ == base::Side::kLeft ? "left" : "right";
  detect_thread_ = std::thread([this, options, name] {
    board::PrepareThread("detect-" + name, options.priority, options.cpu);
    Detect();
  });
  grab_thread_ = std::thread([this, options, name] {
    board::PrepareThread("grab-" + name, options.priority, options.cpu);
    Grab();
  });
}

void CameraLane::Stop() {
  // relaxed: both threads look at it at least every kWaitWorkNs; nothing is published through it.
  stop_.store(true, std::memory_order_relaxed);
  frame_ready_.Signal();
  if (grab_thread_.joinable()) grab_thread_.join();
  if (detect_thread_.joinable()) detect_thread_.join();
  while (base::CameraFrame* const frame = frames_.Pop()) camera_.Release(*frame);
}

void CameraLane::Grab() {
  while (!stop_.load(std::memory_order_relaxed)) {
    base::CameraFrame& frame = frames_.Draft();
    const hal::WaitOutcome outcome = camera_.Wait(kWaitFrameNs, frame);
    // relaxed: a lone flag for the health report.
    gone_.store(outcome == hal::WaitOutcome::kGone, std::memory_order_relaxed);
    if (outcome == hal::WaitOutcome::kEnd) {
      // release: the detect thread that sees it also sees every frame committed before.
      source_ended_.store(true, std::memory_order_release);
      frame_ready_.Signal();
      return;
    }
    if (outcome != hal::WaitOutcome::kFrame) continue;
    frame.stamp.side = side_;
    clock_locked_.store(camera_.Health().clock_locked, std::memory_order_relaxed);
    // relaxed: counters and a time stamp stand for themselves.
    frame_count_.fetch_add(1, std::memory_order_relaxed);
    if (frame.stamp.status == base::FrameStatus::kOk) {
      last_frame_monotonic_ns_.store(board::MonotonicNs(), std::memory_order_relaxed);
    }
    if (base::CameraFrame* const dropped = frames_.Commit()) {
      camera_.Release(*dropped);
      shed_frames_.fetch_add(1, std::memory_order_relaxed);
    }
    frame_ready_.Signal();
  }
}

void CameraLane::Detect() {
  while (!stop_.load(std::memory_order_relaxed)) {
    // acquire: pairs with the release in Grab; read before the last look into the conveyor.
    const bool source_ended = source_ended_.load(std::memory_order_acquire);
    base::CameraFrame* const frame = frames_.Pop();
    if (frame == nullptr) {
      if (source_ended) break;
      frame_ready_.WaitFor(kWaitWorkNs);
      continue;
    }
    const std::int64_t start_ns = board::MonotonicNs();
    pipeline_.Detect(*frame, blobs_.Draft());
    detect_time_.Add(board::MonotonicNs() - start_ns);
    camera_.Release(*frame);
    frames_.GiveBack(frame);
    // relaxed: a counter.
    if (blobs_.Commit() != nullptr) shed_blob_sets_.fetch_add(1, std::memory_order_relaxed);
    consumer_.Signal();
  }
  // release: whoever sees the end also sees every blob set committed before.
  ended_.store(true, std::memory_order_release);
  consumer_.Signal();
}

LaneHealth CameraLane::Health() const {
  LaneHealth health;
  health.camera = camera_.Health();
  // relaxed: counters stand for themselves.
  health.frames = frame_count_.load(std::memory_order_relaxed);
  health.shed_frames = shed_frames_.load(std::memory_order_relaxed);
  health.shed_blob_sets = shed_blob_sets_.load(std::memory_order_relaxed);
  health.gone = gone_.load(std::memory_order_relaxed);
  return health;
}

}  // namespace adit::app
