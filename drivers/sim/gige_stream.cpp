// The stream half of the simulated camera.
#include <sys/socket.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "drivers/linux/system_clock.h"
#include "drivers/sim/gige_camera.h"

namespace adit::sim {
namespace {

constexpr std::size_t kBatch = 32;        // packets handed to the kernel at once
constexpr std::uint64_t kLastId = 65535;  // then comes 1; 0 is never used
constexpr std::size_t kEndPackets = 2;    // leader and trailer

void SleepUntil(base::TimeNs time_ns) {
  const timespec until{time_ns / base::kNsPerS, time_ns % base::kNsPerS};
  clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &until, nullptr);
}

std::uint32_t PayloadPackets(std::size_t frame_bytes, std::size_t payload_bytes) {
  return static_cast<std::uint32_t>((frame_bytes + payload_bytes - 1) / payload_bytes);
}

/// Packets on their way to the kernel.
class PacketBatch {
 public:
  PacketBatch(int socket, const sockaddr_in& to) : socket_(socket), to_(to) {}
  ~PacketBatch() { Flush(); }

  /// `body` must live until Flush.
  void Add(std::span<const std::uint8_t> head, std::span<const std::uint8_t> body) {
    auto& stored = heads_[count_];
    std::copy(head.begin(), head.end(), stored.begin());
    parts_[2 * count_] = {stored.data(), head.size()};
    parts_[2 * count_ + 1] = {const_cast<std::uint8_t*>(body.data()), body.size()};
    messages_[count_] = {};
    messages_[count_].msg_hdr.msg_name = &to_;
    messages_[count_].msg_hdr.msg_namelen = sizeof(to_);
    messages_[count_].msg_hdr.msg_iov = &parts_[2 * count_];
    messages_[count_].msg_hdr.msg_iovlen = body.empty() ? 1 : 2;
    if (++count_ == kBatch) Flush();
  }
  void Flush() {
    if (count_ > 0) sendmmsg(socket_, messages_.data(), static_cast<unsigned>(count_), 0);
    count_ = 0;
  }

 private:
  int socket_;
  sockaddr_in to_;
  std::size_t count_ = 0;
  std::array<std::array<std::uint8_t, kGvspLeaderBytes>, kBatch> heads_{};
  std::array<iovec, 2 * kBatch> parts_{};
  std::array<mmsghdr, kBatch> messages_{};
};

}  // namespace

void GigeCamera::Stream() {
  const auto now = [] { return linux::SystemClock().Now(); };
  const TriggerClock& clock = options_.trigger;
  std::uint64_t trigger = 0;
  while (!stop_.load()) {
    if (!acquiring_.load() || faults_.stall.load() || faults_.vanished.load()) {
      SleepUntil(now() + 5 * base::kNsPerMs);
      const base::DurationNs past_ns = now() - clock.start_ns;
      if (past_ns > 0) trigger = static_cast<std::uint64_t>(past_ns / clock.period_ns) + 1;
      continue;
    }
    const base::TimeNs ready_ns = clock.EdgeNs(trigger) + options_.exposure_ns;
    if (now() > ready_ns + clock.period_ns) {  // rendering cannot keep up: a trigger passes without a frame
      ++frames_late_;
      ++trigger;
      continue;
    }
    KeptFrame& frame = frames_[trigger % kFramesKept];
    {
      const std::lock_guard lock(mutex_);
      frame.trigger = UINT64_MAX;  // no resend from a frame that is being drawn
    }
    source_(trigger, frame.pixels.data());
    SleepUntil(ready_ns);
    Target target;
    {
      const std::lock_guard lock(mutex_);
      const bool ptp = *registers_.ReadWord(kRegPtpStatus) == 9;
      frame.leader = {
          next_id_, static_cast<std::uint64_t>(clock.EdgeNs(trigger) + (ptp ? 0 : options_.clock_offset_ns)),
          *registers_.ReadWord(kRegPixelFormat), *registers_.ReadWord(kRegWidth),
          *registers_.ReadWord(kRegHeight)};
      frame.trigger = trigger;
      next_id_ = static_cast<std::uint16_t>(next_id_ == kLastId ? 1 : next_id_ + 1);
      target = StreamTarget();
    }
    ++trigger;
    if (faults_.drop_frames.load() > 0) {
      --faults_.drop_frames;
      frame.trigger = UINT64_MAX;
      continue;
    }
    const bool truncated = faults_.truncate_frames.load() > 0;
    if (truncated) --faults_.truncate_frames;
    SendFrame(frame, target, truncated);
    ++frames_sent_;
  }
}

void GigeCamera::SendFrame(const KeptFrame& frame, const Target& target, bool truncated) {
  const std::uint32_t packets = PayloadPackets(frame.pixels.size(), target.payload_bytes);
  SendPackets(frame, target, 0, truncated ? packets / 2 : packets + 1);
}

bool GigeCamera::Loses() {
  const double share = faults_.loss.load();
  if (share <= 0) return false;
  // xorshift64: which packets are lost repeats from run to run.
  random_ ^= random_ << 13;
  random_ ^= random_ >> 7;
  random_ ^= random_ << 17;
  return static_cast<double>(random_ >> 11) * 0x1p-53 < share;
}

void GigeCamera::SendPackets(const KeptFrame& frame, const Target& target, std::uint32_t first,
                             std::uint32_t last) {
  const std::uint32_t payload_packets = PayloadPackets(frame.pixels.size(), target.payload_bytes);
  last = std::min<std::uint32_t>(last, payload_packets + kEndPackets - 1);
  PacketBatch batch(stream_socket_.Get(), target.address);
  for (std::uint32_t packet = first; packet <= last; ++packet) {
    if (Loses()) continue;
    if (packet == 0) {
      batch.Add(FormatLeader(frame.leader), {});
    } else if (packet <= payload_packets) {
      const std::size_t at = (packet - 1) * target.payload_bytes;
      const std::size_t bytes = std::min(target.payload_bytes, frame.pixels.size() - at);
      batch.Add(FormatGvspHeader(frame.leader.id, GvspContent::kPayload, packet),
                std::span<const std::uint8_t>(frame.pixels).subspan(at, bytes));
    } else {
      batch.Add(FormatTrailer(frame.leader, packet), {});
    }
  }
}

/// Called by the control thread with the lock held: the stream thread is not drawing into a frame that
/// matches.
void GigeCamera::Resend(const ResendRequest& request) {
  for (const KeptFrame& frame : frames_) {
    if (frame.trigger == UINT64_MAX || frame.leader.id != request.frame_id) continue;
    SendPackets(frame, StreamTarget(), request.first, request.last);
    packets_resent_ += request.last - request.first + 1;
    return;
  }
}

}  // namespace adit::sim
