#include "host/simulated_camera.h"

namespace adit::host {

base::CameraFrame SimulatedCamera::Expose(std::uint64_t trigger) {
  renderer_.Render(trigger, pixels_.data());
  const optics::CameraModel& camera = world_.Camera(side_);
  base::CameraFrame frame;
  frame.stamp.mid_exposure_ns = world_.MidExposureNs(trigger);
  frame.stamp.last_packet_ns = frame.stamp.mid_exposure_ns + 12 * base::kNsPerMs;  // 1.4 MB at 1 Gbit/s
  frame.stamp.trigger = trigger;
  frame.stamp.side = side_;
  frame.image.data = pixels_.data();
  frame.image.width_px = camera.width_px;
  frame.image.height_px = camera.height_px;
  frame.image.bits = world_.GetScene().sensor.bits;
  frame.image.stride_bytes = static_cast<std::ptrdiff_t>(camera.width_px) * frame.image.BytesPerPixel();
  return frame;
}

}  // namespace adit::host
