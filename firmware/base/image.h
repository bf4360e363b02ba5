// One image of one camera, as the drivers deliver it and the stages read it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/base/time.h"

namespace adit::base {

enum class Side : std::uint8_t { kLeft = 0, kRight = 1 };

/// Pixels that someone else owns: rows top to bottom, one byte a pixel for bits == 8, two (host order) for 10
/// to 16.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;
  int bits = 8;  ///< significant bits; the brightest value is (1 << bits) - 1

  int BytesPerPixel() const { return bits > 8 ? 2 : 1; }
  const std::uint8_t* Row(int y) const { return data + y * stride_bytes; }
};

/// Whether a frame can be used. A bad frame is data: it travels on and is counted.
enum class FrameStatus : std::uint8_t { kOk, kIncomplete, kWrongSize, kWrongFormat };

/// When and what: everything about a frame but its pixels. Carried unchanged by every record that comes of
/// it.
struct FrameStamp {
  TimeNs mid_exposure_ns = kNever;  ///< middle of the exposure, box clock
  TimeNs last_packet_ns = kNever;   ///< the frame was complete in memory, box clock
  std::uint64_t trigger = 0;        ///< the camera's frame count, unwrapped; skips where frames were lost
  Side side = Side::kLeft;
  FrameStatus status = FrameStatus::kOk;
};

/// A frame in a driver's pool. Valid until it is given back to the camera that delivered it.
struct CameraFrame {
  FrameStamp stamp;
  ImageView image;
  void* buffer = nullptr;  ///< the driver's handle
};

}  // namespace adit::base
