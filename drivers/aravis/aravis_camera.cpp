#include "drivers/aravis/aravis_camera.h"

#include <arv.h>

#include <chrono>
#include <cmath>

#include "drivers/aravis/session.h"

namespace adit::aravis {
namespace {

constexpr base::DurationNs kReopenPauseNs =
    base::kNsPerS / 2;  // between two tries: a camera boots in seconds
constexpr base::DurationNs kStopLookNs = 20 * base::kNsPerMs;

std::size_t FrameBytes(const AravisSettings& settings) {
  return static_cast<std::size_t>(settings.width_px) * static_cast<std::size_t>(settings.height_px) *
         (settings.bits > 8 ? 2 : 1);
}

std::unique_ptr<Slot> MakeSlot(const AravisSettings& settings, const hal::Clock& clock) {
  auto slot = std::make_unique<Slot>();
  slot->clock = &clock;
  slot->memory = linux::AllocateHuge(FrameBytes(settings));
  slot->buffer.reset(arv_buffer_new_full(FrameBytes(settings), slot->memory.get(), slot.get(), nullptr));
  return slot;
}

void Sleep(base::DurationNs duration_ns) {
  std::this_thread::sleep_for(std::chrono::nanoseconds(duration_ns));
}

}  // namespace

AravisCamera::AravisCamera(const AravisSettings& settings, const hal::Clock& clock)
    : settings_(settings), clock_(clock) {
  for (int i = 0; i < settings.buffers; ++i) slots_.push_back(MakeSlot(settings, clock));
}

AravisCamera::~AravisCamera() { Stop(); }

std::string AravisCamera::Name() const { return "camera " + settings_.device; }

base::Result<void> AravisCamera::Start() {
  stop_.store(false, std::memory_order_relaxed);  // relaxed: no reopener runs yet
  counter_.Restart();
  clock_map_.Restart();
  auto session = Session::Open(settings_, slots_);
  if (!session) return session.error();
  session_ = std::move(*session);
  clock_locked_.store(session_->PtpLocked(), std::memory_order_relaxed);  // relaxed: a lone flag
  link_.store(Link::kOpen, std::memory_order_release);                    // release: publishes session_
  return {};
}

void AravisCamera::Stop() {
  stop_.store(true, std::memory_order_relaxed);  // relaxed: the reopener looks at it every kStopLookNs
  if (reopener_.joinable()) reopener_.join();
  link_.store(Link::kClosed, std::memory_order_relaxed);
  KeepCounts();
  session_.reset();
}

void AravisCamera::Release(const base::CameraFrame& frame) {
  // release: what the stages read of the buffer is over before Aravis writes to it again.
  static_cast<Slot*>(frame.buffer)->released.store(true, std::memory_order_release);
}

void AravisCamera::PushReleased() {
  for (const auto& slot : slots_) {
    // acquire: pairs with the release above.
    if (!slot->with_stages || !slot->released.load(std::memory_order_acquire)) continue;
    slot->released.store(false, std::memory_order_relaxed);
    slot->with_stages = false;
    session_->Push(*slot);
  }
}

hal::WaitOutcome AravisCamera::Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) {
  // acquire: pairs with the reopener's release, its session is complete.
  const Link link = link_.load(std::memory_order_acquire);
  if (link == Link::kClosed) return hal::WaitOutcome::kGone;
  if (link != Link::kOpen) return WaitForReopening(timeout_ns);
  if (session_->Lost()) {
    KeepCounts();
    link_.store(Link::kReopening, std::memory_order_relaxed);  // relaxed: the thread's start publishes it
    reopener_ = std::thread([this] { Reopen(); });
    return hal::WaitOutcome::kGone;
  }
  PushReleased();
  ArvBuffer* const buffer =
      arv_stream_timeout_pop_buffer(session_->Stream(), static_cast<guint64>(timeout_ns / base::kNsPerUs));
  if (buffer == nullptr) return hal::WaitOutcome::kTimeout;
  auto* const slot = static_cast<Slot*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
  g_object_unref(buffer);  // the stream's reference; ours stays
  if (arv_buffer_get_frame_id(buffer) == 0) {
    // Its leader never came: neither date nor id. The gap before the next frame counts it.
    session_->Push(*slot);
    return hal::WaitOutcome::kTimeout;
  }
  slot->with_stages = true;
  Describe(*slot, frame);
  // relaxed: counters stand for themselves.
  delivered_.fetch_add(1, std::memory_order_relaxed);
  if (frame.stamp.status != base::FrameStatus::kOk) incomplete_.fetch_add(1, std::memory_order_relaxed);
  resent_.store(resent_before_ + session_->Resent(), std::memory_order_relaxed);
  starved_.store(starved_before_ + session_->Underruns(), std::memory_order_relaxed);
  return hal::WaitOutcome::kFrame;
}

/// A session counts from zero: what this one has counted is the next one's beginning.
void AravisCamera::KeepCounts() {
  if (!session_) return;
  resent_before_ += session_->Resent();
  starved_before_ += session_->Underruns();
}

hal::WaitOutcome AravisCamera::WaitForReopening(base::DurationNs timeout_ns) {
  if (link_.load(std::memory_order_acquire) == Link::kReopening) {
    Sleep(timeout_ns);
    return hal::WaitOutcome::kGone;
  }
  reopener_.join();
  counter_.Restart();
  clock_map_.Restart();
  reconnects_.fetch_add(1, std::memory_order_relaxed);
  clock_locked_.store(session_->PtpLocked(), std::memory_order_relaxed);
  link_.store(Link::kOpen, std::memory_order_relaxed);  // relaxed: only this thread reads it as kOpen
  return hal::WaitOutcome::kTimeout;
}

/// Runs in a thread of its own; Wait's thread touches neither session nor slots meanwhile.
void AravisCamera::Reopen() {
  session_.reset();
  while (!stop_.load(std::memory_order_relaxed)) {
    auto session = Session::Open(settings_, slots_);
    if (session) {
      session_ = std::move(*session);
      link_.store(Link::kReopened, std::memory_order_release);  // release: publishes session_
      return;
    }
    for (base::DurationNs slept_ns = 0; slept_ns < kReopenPauseNs && !stop_.load(std::memory_order_relaxed);
         slept_ns += kStopLookNs) {
      Sleep(kStopLookNs);
    }
  }
}

base::FrameStatus AravisCamera::StatusOf(const Slot& slot) const {
  ArvBuffer* const buffer = slot.buffer.get();
  if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SIZE_MISMATCH) return base::FrameStatus::kWrongSize;
  if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS) return base::FrameStatus::kIncomplete;
  if (arv_buffer_get_payload_type(buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE)
    return base::FrameStatus::kWrongFormat;
  const ArvPixelFormat format = arv_buffer_get_image_pixel_format(buffer);
  const ArvPixelFormat wanted = settings_.bits == 8    ? ARV_PIXEL_FORMAT_MONO_8
                                : settings_.bits == 10 ? ARV_PIXEL_FORMAT_MONO_10
                                                       : ARV_PIXEL_FORMAT_MONO_12;
  if (format != wanted) return base::FrameStatus::kWrongFormat;
  const bool size = arv_buffer_get_image_width(buffer) == settings_.width_px &&
                    arv_buffer_get_image_height(buffer) == settings_.height_px;
  return size ? base::FrameStatus::kOk : base::FrameStatus::kWrongSize;
}

void AravisCamera::Describe(Slot& slot, base::CameraFrame& frame) {
  frame.buffer = &slot;
  frame.stamp.side = settings_.side;
  frame.stamp.status = StatusOf(slot);
  std::uint64_t missed = 0;
  frame.stamp.trigger = counter_.Count(arv_buffer_get_frame_id(slot.buffer.get()), missed);
  missed_.fetch_add(missed, std::memory_order_relaxed);
  // Aravis hands the buffer over before it calls back: if this thread was faster, now is when the frame was
  // done. That call may come when the buffer is pushed again; what then stands there is older than the next
  // leader. relaxed: a lone time stamp; either value is right.
  const base::TimeNs done_ns = slot.done_ns.exchange(base::kNever, std::memory_order_relaxed);
  const auto leader_ns = static_cast<base::TimeNs>(arv_buffer_get_system_timestamp(slot.buffer.get()));
  frame.stamp.last_packet_ns = done_ns < leader_ns ? clock_.Now() : done_ns;
  auto edge_ns = static_cast<base::TimeNs>(arv_buffer_get_timestamp(slot.buffer.get()));
  if (!clock_locked_.load(std::memory_order_relaxed))
    edge_ns = clock_map_.ToBox(edge_ns, frame.stamp.last_packet_ns);
  frame.stamp.mid_exposure_ns =
      edge_ns + static_cast<base::DurationNs>(std::llround(settings_.exposure_us * base::kNsPerUs / 2));
  const std::ptrdiff_t stride_bytes =
      static_cast<std::ptrdiff_t>(settings_.width_px) * (settings_.bits > 8 ? 2 : 1);
  frame.image = {slot.memory.get(), settings_.width_px, settings_.height_px, stride_bytes, settings_.bits};
}

hal::CameraHealth AravisCamera::Health() const {
  hal::CameraHealth health;
  // relaxed: counters stand for themselves.
  health.delivered = delivered_.load(std::memory_order_relaxed);
  health.incomplete = incomplete_.load(std::memory_order_relaxed);
  health.missed = missed_.load(std::memory_order_relaxed);
  health.resent = resent_.load(std::memory_order_relaxed);
  health.reconnects = reconnects_.load(std::memory_order_relaxed);
  health.starved = starved_.load(std::memory_order_relaxed);
  health.clock_locked = clock_locked_.load(std::memory_order_relaxed);
  return health;
}

}  // namespace adit::aravis
