#include "drivers/recording/recording_camera.h"

#include <algorithm>
#include <thread>

namespace adit::recording {
namespace {

/// Half the median interval of a side: nearer instants of the two sides belong to one trigger.
base::DurationNs PairingLimitNs(const std::vector<ImageEntry>& entries) {
  if (entries.size() < 2) return 0;
  std::vector<base::DurationNs> intervals;
  for (std::size_t i = 1; i < entries.size(); ++i)
    intervals.push_back(entries[i].mid_exposure_ns - entries[i - 1].mid_exposure_ns);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle / 2;
}

}  // namespace

std::vector<std::uint64_t> CountTriggers(const std::vector<ImageEntry>& entries,
                                         const std::vector<ImageEntry>& others) {
  const base::DurationNs limit_ns = std::max(PairingLimitNs(entries), PairingLimitNs(others));
  std::vector<std::uint64_t> triggers;
  std::size_t other = 0;
  std::uint64_t trigger = 0;
  for (const ImageEntry& entry : entries) {
    // Instants of the other side that this side missed count too.
    while (other < others.size() && others[other].mid_exposure_ns < entry.mid_exposure_ns - limit_ns)
      ++other, ++trigger;
    if (other < others.size() && others[other].mid_exposure_ns <= entry.mid_exposure_ns + limit_ns) ++other;
    triggers.push_back(trigger++);
  }
  return triggers;
}

RecordingCamera::RecordingCamera(ReplayOptions options, const hal::Clock& clock)
    : options_(std::move(options)), clock_(clock) {}

base::Result<void> RecordingCamera::Start() {
  auto recording = OpenRecording(options_.folder);
  if (!recording) return recording.error();
  first_ns_ = std::min(recording->left.front().mid_exposure_ns, recording->right.front().mid_exposure_ns);
  if (options_.side == base::Side::kRight) std::swap(recording->left, recording->right);
  triggers_ = CountTriggers(recording->left, recording->right);
  entries_ = std::move(recording->left);
  const auto first = ReadCameraImage(entries_.front().path);
  if (!first) return first.error();
  if (options_.width_px == 0) options_.width_px = first->width_px, options_.height_px = first->height_px;
  if (first->width_px != options_.width_px || first->height_px != options_.height_px) {
    return base::Error{base::ErrorCode::kOutOfRange, entries_.front().path,
                       "is " + std::to_string(first->width_px) + " x " + std::to_string(first->height_px) +
                           " px; the rig's camera has " + std::to_string(options_.width_px) + " x " +
                           std::to_string(options_.height_px)};
  }
  pool_.clear();
  for (int i = 0; i < std::max(options_.buffers, 1); ++i) {
    pool_.push_back(std::make_unique<Buffer>());
    pool_.back()->image = *first;
  }
  next_ = 0;
  started_ = Monotonic::now();
  // The first instant is at the epoch, neither before it (a frame out of the future) nor later (an old one).
  if (options_.epoch_ns != base::kNever && options_.pace == Pace::kRecorded)
    started_ += std::chrono::nanoseconds(options_.epoch_ns - clock_.Now());
  return {};
}

RecordingCamera::Buffer* RecordingCamera::TakeFree() {
  for (const auto& buffer : pool_) {
    // acquire: pairs with Release; whoever read this buffer is done before it is filled again.
    if (!buffer->taken.exchange(true, std::memory_order_acquire)) return buffer.get();
  }
  return nullptr;
}

void RecordingCamera::Fill(Buffer& buffer, base::CameraFrame& frame) {
  const ImageEntry& entry = entries_[next_];
  auto image = ReadCameraImage(entry.path);
  frame.stamp.status = base::FrameStatus::kOk;
  if (!image) {
    frame.stamp.status = base::FrameStatus::kIncomplete;
    incomplete_.fetch_add(1, std::memory_order_relaxed);  // relaxed: a count, nothing is published through it
  } else if (image->width_px != options_.width_px || image->height_px != options_.height_px) {
    frame.stamp.status = base::FrameStatus::kWrongSize;
  } else if (image->bits != buffer.image.bits) {
    frame.stamp.status = base::FrameStatus::kWrongFormat;
  } else {
    buffer.image = std::move(*image);
  }
  const base::DurationNs shift_ns = options_.epoch_ns == base::kNever ? 0 : options_.epoch_ns - first_ns_;
  frame.stamp.mid_exposure_ns = entry.mid_exposure_ns + shift_ns;
  frame.stamp.last_packet_ns = clock_.Now();
  frame.stamp.trigger = triggers_[next_];
  frame.stamp.side = options_.side;
  frame.image = buffer.image.View();
  frame.buffer = &buffer;
  // relaxed: counts, nothing is published through them.
  delivered_.fetch_add(1, std::memory_order_relaxed);
  const std::uint64_t expected = next_ == 0 ? triggers_[next_] : triggers_[next_ - 1] + 1;
  missed_.fetch_add(triggers_[next_] - expected, std::memory_order_relaxed);
  ++next_;
}

hal::WaitOutcome RecordingCamera::Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) {
  const auto deadline = Monotonic::now() + std::chrono::nanoseconds(timeout_ns);
  if (next_ >= entries_.size()) return hal::WaitOutcome::kEnd;
  if (options_.pace == Pace::kRecorded) {
    const auto due = started_ + std::chrono::nanoseconds(entries_[next_].mid_exposure_ns - first_ns_);
    std::this_thread::sleep_until(std::min(due, deadline));
    if (due > deadline) return hal::WaitOutcome::kTimeout;
  }
  constexpr auto kPoll = std::chrono::microseconds(200);
  Buffer* buffer = TakeFree();
  for (; buffer == nullptr && Monotonic::now() < deadline; buffer = TakeFree())
    std::this_thread::sleep_for(kPoll);
  if (buffer == nullptr) return hal::WaitOutcome::kTimeout;
  Fill(*buffer, frame);
  return hal::WaitOutcome::kFrame;
}

void RecordingCamera::Release(const base::CameraFrame& frame) {
  // release: pairs with TakeFree.
  static_cast<Buffer*>(frame.buffer)->taken.store(false, std::memory_order_release);
}

hal::CameraHealth RecordingCamera::Health() const {
  hal::CameraHealth health;
  // relaxed: counts, nothing is published through them.
  health.delivered = delivered_.load(std::memory_order_relaxed);
  health.incomplete = incomplete_.load(std::memory_order_relaxed);
  health.missed = missed_.load(std::memory_order_relaxed);
  health.clock_locked = true;
  return health;
}

std::string RecordingCamera::Name() const {
  return options_.folder + (options_.side == base::Side::kLeft ? "/cam0" : "/cam1");
}

void RecordingCamera::Stop() {}

}  // namespace adit::recording
