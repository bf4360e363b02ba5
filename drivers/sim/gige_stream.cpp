// The stream half of the simulated camera.
#include <sys/socket.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "drivers/linux/system_clock.h"
#include "drivers/sim/gige_camera.h"

namespace adit::sim {
namespace {

constexpr std::size_t kBatch = 32;  // packets handed to the kernel at once

void SleepUntil(base::TimeNs time_ns) {
  const timespec until{time_ns / base::kNsPerS, time_ns % base::kNsPerS};
  clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &until, nullptr);
}

std::uint32_t PayloadPackets(std::size_t frame_bytes, std::size_t payload_bytes) {
  return static_cast<std::uint32_t>((frame_bytes + payload_bytes - 1) / payload_bytes);
}

/// The trailer's packet id.
std::uint32_t LastPacket(std::size_t frame_bytes, std::size_t payload_bytes) {
  return PayloadPackets(frame_bytes, payload_bytes) + 1;
}

/// Uses up one of the faults that are still to happen.
bool TakeOne(std::atomic<std::uint32_t>& faults) {
  if (faults.load() == 0) return false;
  --faults;
  return true;
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
      frame.trigger = kNoTrigger;  // no resend from a frame that is being drawn
    }
    source_(trigger, frame.pixels.data());
    SleepUntil(ready_ns);
    const bool dropped = TakeOne(faults_.drop_frames),
               truncated = !dropped && TakeOne(faults_.truncate_frames);
    const Target target = Stamp(frame, trigger, !dropped && !truncated);
    ++trigger;
    if (dropped) continue;
    SendFrame(frame, target, truncated);
    ++frames_sent_;
  }
}

/// Fills in the leader. A frame that is not `whole` is never sent again.
GigeCamera::Target GigeCamera::Stamp(KeptFrame& frame, std::uint64_t trigger, bool whole) {
  const std::lock_guard lock(mutex_);
  const base::DurationNs offset_ns = *registers_.ReadWord(kRegPtpStatus) == 9 ? 0 : options_.clock_offset_ns;
  frame.leader = {next_id_, static_cast<std::uint64_t>(options_.trigger.EdgeNs(trigger) + offset_ns),
                  *registers_.ReadWord(kRegPixelFormat), *registers_.ReadWord(kRegWidth),
                  *registers_.ReadWord(kRegHeight)};
  frame.trigger = whole ? trigger : kNoTrigger;
  next_id_ = NextFrameId(next_id_);
  return StreamTarget();
}

void GigeCamera::SendFrame(const KeptFrame& frame, const Target& target, bool truncated) {
  const std::uint32_t packets = PayloadPackets(frame.pixels.size(), target.payload_bytes);
  SendPackets(frame, target, {frame.leader.id, 0, truncated ? packets / 2 : packets + 1}, true);
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

void GigeCamera::SendPackets(const KeptFrame& frame, const Target& target, const ResendRequest& range,
                             bool lossy) {
  const std::uint32_t payload_packets = PayloadPackets(frame.pixels.size(), target.payload_bytes);
  const std::uint32_t last = std::min(range.last, LastPacket(frame.pixels.size(), target.payload_bytes));
  PacketBatch batch(stream_socket_.Get(), target.address);
  for (std::uint32_t packet = range.first; packet <= last; ++packet) {
    if (lossy && Loses()) continue;
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
    if (frame.trigger == kNoTrigger || frame.leader.id != request.frame_id) continue;
    const Target target = StreamTarget();
    SendPackets(frame, target, request, false);
    const std::uint32_t last = std::min(request.last, LastPacket(frame.pixels.size(), target.payload_bytes));
    if (last >= request.first) packets_resent_ += last - request.first + 1;
    return;
  }
}

}  // namespace adit::sim
