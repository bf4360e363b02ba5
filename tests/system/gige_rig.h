// A simulated camera whose frames tell their own number, and the driver that looks at it.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "drivers/aravis/aravis_camera.h"
#include "drivers/linux/system_clock.h"
#include "drivers/sim/gige_camera.h"

namespace adit::test {

/// What a delivered frame was, by its stamp and by its own pixels.
struct Seen {
  base::FrameStamp stamp;
  bool right = false;         ///< every pixel is that of frame `drawn`; looked at in complete frames only
  std::uint64_t drawn = 0;    ///< count of frames drawn; as the camera's frame id, it skips no late trigger
  std::uint64_t trigger = 0;  ///< of 24 bits
};

struct RigOptions {
  int bits = 8;
  base::DurationNs receiver_delay_ns = 0;  ///< Aravis' thread is held up for so long while it dates a frame
  sim::GigeOptions camera;
  aravis::AravisSettings driver;
};

/// The system's clock, that holds up every thread but the one that made it.
class HoldingClock final : public hal::Clock {
 public:
  explicit HoldingClock(base::DurationNs delay_ns) : delay_ns_(delay_ns) {}
  base::TimeNs Now() const override;

 private:
  base::DurationNs delay_ns_;
  std::thread::id free_ = std::this_thread::get_id();
};

/// 320 x 240, Mono8, 60 Hz on 127.0.0.1, over a UDP socket with packets of 1500 bytes.
RigOptions SmallRig();

class GigeRig {
 public:
  explicit GigeRig(const RigOptions& options);

  /// Both, camera first; the reason in `failure` if either declines.
  bool Start();
  const std::string& Failure() const { return failure_; }

  /// The next `count` frames, each given back at once; fewer when they do not come within 10 s.
  std::vector<Seen> Take(std::size_t count);
  /// Waits for one frame and keeps its buffer.
  hal::WaitOutcome Wait(base::CameraFrame& frame) { return driver.Wait(100 * base::kNsPerMs, frame); }
  Seen Look(const base::CameraFrame& frame) const;
  /// Bytes of the camera's memory, as it tells anyone.
  std::vector<std::uint8_t> Memory(std::uint32_t address, std::uint8_t bytes);

  const HoldingClock clock;
  sim::GigeCamera camera;
  aravis::AravisCamera driver;

 private:
  void Draw(std::uint64_t trigger, std::uint8_t* pixels);

  RigOptions options_;
  std::atomic<std::uint64_t> drawn_{0};
  std::string failure_;
};

}  // namespace adit::test
