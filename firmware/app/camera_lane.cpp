#include "firmware/app/camera_lane.h"

namespace adit::app {
namespace {

constexpr base::DurationNs kWaitFrameNs = 20 * base::kNsPerMs;  // how soon a stop or a silence is noticed
constexpr base::DurationNs kWaitWorkNs = 100 * base::kNsPerMs;  // bounded, so that Stop always ends

}  // namespace

CameraLane::CameraLane(base::Side side, const LaneNeighbours& neighbours)
    : side_(side),
      camera_(neighbours.camera),
      pipeline_(neighbours.pipeline),
      consumer_(neighbours.consumer),
      latency_(neighbours.latency) {}

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
  // relaxed: the grab thread looks at it at least every kWaitFrameNs; nothing is published through it.
  stop_.store(true, std::memory_order_relaxed);
  if (grab_thread_.joinable()) grab_thread_.join();
  if (detect_thread_.joinable()) detect_thread_.join();
}

void CameraLane::Grab() {
  while (!stop_.load(std::memory_order_relaxed)) {
    TakenFrame& taken = frames_.Draft();
    base::CameraFrame& frame = taken.frame;
    const hal::WaitOutcome outcome = camera_.Wait(kWaitFrameNs, frame);
    // relaxed: a lone flag for the health report.
    gone_.store(outcome == hal::WaitOutcome::kGone, std::memory_order_relaxed);
    if (outcome == hal::WaitOutcome::kEnd) break;
    if (outcome != hal::WaitOutcome::kFrame) continue;
    frame.stamp.side = side_;
    taken.taken_monotonic_ns = board::MonotonicNs();
    latency_[Span::kExposureToPacket].Add(frame.stamp.last_packet_ns - frame.stamp.mid_exposure_ns);
    latency_[Span::kPacketToGrab].Add(clock_.Now() - frame.stamp.last_packet_ns);
    clock_locked_.store(camera_.Health().clock_locked, std::memory_order_relaxed);
    // relaxed: counters and a time stamp stand for themselves.
    frame_count_.fetch_add(1, std::memory_order_relaxed);
    if (frame.stamp.status == base::FrameStatus::kOk) {
      last_frame_monotonic_ns_.store(taken.taken_monotonic_ns, std::memory_order_relaxed);
    }
    if (const TakenFrame* const dropped = frames_.Commit()) {
      camera_.Release(dropped->frame);
      shed_frames_.fetch_add(1, std::memory_order_relaxed);
    }
    frame_ready_.Signal();
  }
  // release: the detect thread that sees it also sees every frame committed before.
  source_ended_.store(true, std::memory_order_release);
  frame_ready_.Signal();
}

void CameraLane::Detect() {
  for (;;) {
    // acquire: pairs with the release in Grab; read before the last look into the conveyor.
    const bool source_ended = source_ended_.load(std::memory_order_acquire);
    TakenFrame* const taken = frames_.Pop();
    if (taken == nullptr) {
      if (source_ended) break;
      frame_ready_.WaitFor(kWaitWorkNs);
      continue;
    }
    const std::int64_t start_ns = board::MonotonicNs();
    Detection& detection = detections_.Draft();
    pipeline_.Detect(taken->frame, detection.blobs);
    detection.ready_monotonic_ns = board::MonotonicNs();
    latency_[Span::kGrabToDetect].Add(start_ns - taken->taken_monotonic_ns);
    latency_[Span::kDetect].Add(detection.ready_monotonic_ns - start_ns);
    camera_.Release(taken->frame);
    frames_.GiveBack(taken);
    // relaxed: a counter.
    if (detections_.Commit() != nullptr) shed_blob_sets_.fetch_add(1, std::memory_order_relaxed);
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
