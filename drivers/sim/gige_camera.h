// A simulated GigE Vision camera: serves control and image stream from one IPv4 address, and fails on
// command.
#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/file_descriptor.h"
#include "drivers/sim/gige_protocol.h"
#include "drivers/sim/gige_registers.h"
#include "firmware/base/result.h"
#include "firmware/base/time.h"

namespace adit::sim {

/// Fills the pixels of one trigger's frame; called from the camera's stream thread.
using FrameSource = std::function<void(std::uint64_t trigger, std::uint8_t* pixels)>;

/// The common hardware trigger: edge n at start + n periods of CLOCK_REALTIME. Cameras with the same one have
/// no skew.
struct TriggerClock {
  base::TimeNs start_ns = 0;
  base::DurationNs period_ns = base::kNsPerS / 60;
  base::TimeNs EdgeNs(std::uint64_t trigger) const {
    return start_ns + static_cast<base::DurationNs>(trigger) * period_ns;
  }
};

struct GigeOptions {
  GigeIdentity identity;
  TriggerClock trigger;
  base::DurationNs exposure_ns = base::kNsPerMs;  ///< a frame is sent when it is over
  std::size_t frame_bytes = 1400 * 1024;
  std::uint16_t first_frame_id = 1;
  bool has_ptp = true;                   ///< else the time stamps are of a clock of its own
  base::DurationNs clock_offset_ns = 0;  ///< of that clock
};

/// What can be made to go wrong. Set from any thread.
struct GigeFaults {
  std::atomic<double> loss{0};                    ///< share of stream packets that do not go out at first
  std::atomic<std::uint32_t> drop_frames{0};      ///< so many frames are never sent, their ids used up
  std::atomic<std::uint32_t> truncate_frames{0};  ///< so many frames miss their second half, for good
  std::atomic<bool> stall{false};                 ///< no frames, but control answers
  std::atomic<bool> vanished{false};              ///< answers nothing; comes back as after power-on
};

/// Threads: one for control, one for the stream. Start, Stop and the destructor belong to one thread.
class GigeCamera {
 public:
  GigeCamera(const GigeOptions& options, FrameSource source);
  ~GigeCamera();

  /// Binds the sockets and starts. Declines with the address.
  base::Result<void> Start();
  void Stop();
  GigeFaults& Faults() { return faults_; }
  /// What the camera answers to one control packet of `peer`; empty if nothing. Needs no Start.
  std::vector<std::uint8_t> Reply(std::span<const std::uint8_t> packet, const sockaddr_in& peer);

  std::uint64_t FramesSent() const { return frames_sent_.load(); }
  std::uint64_t FramesLate() const {
    return frames_late_.load();
  }  ///< triggers skipped: rendering was too slow
  std::uint64_t PacketsResent() const { return packets_resent_.load(); }

 private:
  static constexpr std::size_t kFramesKept = 8;  // for resends: 133 ms at 60 Hz
  static constexpr std::uint64_t kNoTrigger = UINT64_MAX;
  struct KeptFrame {
    std::vector<std::uint8_t> pixels;
    GvspFrame leader;
    std::uint64_t trigger = kNoTrigger;  ///< kNoTrigger: not for resends
  };
  struct Target {
    sockaddr_in address{};
    std::size_t payload_bytes = 0;
  };

  base::Result<int> Bind(std::uint32_t address, std::uint16_t port) const;
  void Control();
  void Answer(int socket);
  std::vector<std::uint8_t> Obey(const GvcpCommand& command, const sockaddr_in& peer);
  std::vector<std::uint8_t> ReadRegisters(const GvcpCommand& command) const;
  std::vector<std::uint8_t> ReadMemory(const GvcpCommand& command) const;
  std::vector<std::uint8_t> WriteRegisters(const GvcpCommand& command, const sockaddr_in& peer);
  std::vector<std::uint8_t> WriteMemory(const GvcpCommand& command, const sockaddr_in& peer);
  GvcpStatus Write(std::uint32_t address, std::span<const std::uint8_t> bytes, const sockaddr_in& peer);
  void Resend(const ResendRequest& request);
  void PowerOn();
  void LetGoOfSilentController();
  void SendTestPacket();

  void Stream();
  Target StreamTarget();
  Target Stamp(KeptFrame& frame, std::uint64_t trigger, bool whole);
  void SendFrame(const KeptFrame& frame, const Target& target, bool truncated);
  void SendPackets(const KeptFrame& frame, const Target& target, const ResendRequest& range, bool lossy);
  bool Loses();

  GigeOptions options_;
  FrameSource source_;
  GigeFaults faults_;
  std::array<linux::FileDescriptor, 3> control_sockets_;  ///< own address, and two that hear broadcasts
  linux::FileDescriptor stream_socket_;
  std::thread control_thread_, stream_thread_;
  std::atomic<bool> stop_{false}, acquiring_{false};

  std::mutex mutex_;  ///< registers and kept frames; a simulator may lock
  GigeRegisters registers_;
  std::array<KeptFrame, kFramesKept> frames_;
  sockaddr_in controller_{};
  std::int64_t last_heard_ns_ = 0;
  std::uint16_t next_id_ = 1;
  std::uint64_t random_ = 0x9E3779B97F4A7C15ULL;  ///< the stream thread's
  std::atomic<std::uint64_t> frames_sent_{0}, frames_late_{0}, packets_resent_{0};
};

}  // namespace adit::sim
