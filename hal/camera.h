// A camera as the box needs it: triggered frames out of the driver's own pool.
#pragma once

#include <cstdint>
#include <string>

#include "firmware/base/image.h"
#include "firmware/base/result.h"

namespace adit::hal {

enum class WaitOutcome : std::uint8_t {
  kFrame,    ///< a frame was delivered; give it back with Release
  kTimeout,  ///< nothing came in time; the camera is still there
  kGone,     ///< the camera has vanished; the driver is trying to get it back
  kEnd,      ///< a recording is over; no more frames will come
};

/// What a driver counts; monotonic since Start.
struct CameraHealth {
  std::uint64_t delivered = 0;   ///< frames handed out, complete or not
  std::uint64_t incomplete = 0;  ///< frames handed out with missing packets
  std::uint64_t missed = 0;      ///< triggers without a frame (gaps in the frame ids)
  std::uint64_t resent = 0;      ///< packets that came only when asked for again
  std::uint64_t reconnects = 0;  ///< times the camera came back
  std::uint64_t starved = 0;     ///< packets that found no buffer free; their frames are among the missed
  bool clock_locked = false;     ///< the timestamps are on the box clock (PTP or simulated)
};

/// One camera. Start and Stop belong to the supervising thread, Wait to one grab thread; Release and Health
/// may be called from any thread.
class Camera {
 public:
  virtual ~Camera() = default;
  /// Opens, configures and arms. Declines with the device and the feature that failed.
  virtual base::Result<void> Start() = 0;
  /// Waits at most `timeout_ns` for the next frame. A camera that vanished is reopened inside, without end.
  virtual WaitOutcome Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) = 0;
  /// Gives the buffer back to the pool.
  virtual void Release(const base::CameraFrame& frame) = 0;
  virtual CameraHealth Health() const = 0;
  virtual std::string Name() const = 0;
  virtual void Stop() = 0;
};

}  // namespace adit::hal
