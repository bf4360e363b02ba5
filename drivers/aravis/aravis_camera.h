// A GigE Vision camera through Aravis.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/aravis/frame_clock.h"
#include "hal/camera.h"
#include "hal/clock.h"

namespace adit::aravis {

struct AravisSettings {
  std::string device;  ///< IPv4 address or device id
  base::Side side = base::Side::kLeft;
  int width_px = 1400, height_px = 1024;
  int bits = 8;  ///< 8, 10, 12: Mono8, Mono10, Mono12
  double exposure_us = 1000;
  double gain_db = 0;
  int packet_size = 9000;     ///< bytes; the network must carry them whole
  bool packet_socket = true;  ///< a packet socket (CAP_NET_RAW) or a UDP socket
  std::string trigger_source = "Line0";
  bool ptp = true;
  int buffers = 16;
  /// Called once in each connection's receiving thread, which is Aravis' own: names it, asks for its
  /// priority.
  std::function<void()> prepare_receiving;
};

class Session;
struct Slot;

/// One camera with its own frame pool: Aravis writes into the memory that the stages read. Waits, reopening
/// and buffers belong to the thread that calls Wait; Release sets a flag. A camera that vanished is reopened
/// by a thread of its own.
///
/// mid_exposure_ns: the leader's time stamp is the trigger edge, the start of the exposure; half the exposure
/// is added. With PTP locked it is on the box clock; else ClockMap puts it there and Health says that the
/// clock is not locked. last_packet_ns: the box clock in Aravis' receiving thread when it declared the buffer
/// done.
class AravisCamera final : public hal::Camera {
 public:
  /// `clock` outlives the camera and is CLOCK_REALTIME, which Aravis dates leaders by.
  AravisCamera(const AravisSettings& settings, const hal::Clock& clock);
  ~AravisCamera() override;

  base::Result<void> Start() override;
  hal::WaitOutcome Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) override;
  void Release(const base::CameraFrame& frame) override;
  hal::CameraHealth Health() const override;
  std::string Name() const override;
  void Stop() override;

 private:
  enum class Link : std::uint8_t { kClosed, kOpen, kReopening, kReopened };

  void PushReleased();
  void KeepCounts();
  void Reopen();
  hal::WaitOutcome WaitForReopening(base::DurationNs timeout_ns);
  void Describe(Slot& slot, base::CameraFrame& frame);
  base::FrameStatus StatusOf(const Slot& slot) const;

  AravisSettings settings_;
  const hal::Clock& clock_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::unique_ptr<Session> session_;
  std::thread reopener_;
  std::atomic<Link> link_{Link::kClosed};
  std::atomic<bool> stop_{false};
  FrameCounter counter_;
  ClockMap clock_map_;
  std::uint64_t resent_before_ = 0, starved_before_ = 0;  ///< of the sessions before this one
  std::atomic<std::uint64_t> delivered_{0}, incomplete_{0}, missed_{0}, resent_{0}, reconnects_{0},
      starved_{0};
  std::atomic<bool> clock_locked_{false};
};

}  // namespace adit::aravis
