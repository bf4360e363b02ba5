#include "tests/support/fake_camera.h"

#include <chrono>
#include <cmath>
#include <thread>

namespace adit::support {
namespace {

base::TimeNs BoxNow() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void DrawSpot(const SyntheticCamera& camera, const Eigen::Vector2d& centre_px,
              std::vector<std::uint8_t>& picture) {
  constexpr double kSigmaPx = 1.5, kPeakDn = 180;
  constexpr int kReachPx = 8;
  const int x0 = static_cast<int>(std::lround(centre_px.x())),
            y0 = static_cast<int>(std::lround(centre_px.y()));
  for (int y = y0 - kReachPx; y <= y0 + kReachPx; ++y) {
    for (int x = x0 - kReachPx; x <= x0 + kReachPx; ++x) {
      if (x < 0 || y < 0 || x >= camera.width_px || y >= camera.height_px) continue;
      const double r2 = (Eigen::Vector2d(x, y) - centre_px).squaredNorm();
      auto& pixel = picture[static_cast<std::size_t>(y * camera.width_px + x)];
      pixel =
          static_cast<std::uint8_t>(pixel + std::lround(kPeakDn * std::exp(-r2 / (2 * kSigmaPx * kSigmaPx))));
    }
  }
}

}  // namespace

std::vector<std::uint8_t> DrawBar(const SyntheticCamera& camera, const SyntheticBar& bar) {
  constexpr std::uint8_t kDarkDn = 6;
  std::vector<std::uint8_t> picture(static_cast<std::size_t>(camera.width_px * camera.height_px), kDarkDn);
  for (const double place_m : bar.target.leds_m) {
    const auto ideal_px = camera.ProjectIdeal(bar.Point(place_m));
    if (ideal_px) DrawSpot(camera, camera.Distorted(*ideal_px), picture);
  }
  return picture;
}

FakeCamera::FakeCamera(base::Side side, double rate_hz, std::vector<std::uint8_t> picture)
    : side_(side), period_ns_(static_cast<base::DurationNs>(1e9 / rate_hz)), picture_(std::move(picture)) {}

hal::WaitOutcome FakeCamera::Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) {
  const base::TimeNs start_ns = start_ns_.load();
  const base::TimeNs due_ns = start_ns + static_cast<base::DurationNs>(next_) * period_ns_;
  if (start_ns == base::kNever || due_ns - BoxNow() > timeout_ns) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(timeout_ns));
    return hal::WaitOutcome::kTimeout;
  }
  std::this_thread::sleep_for(std::chrono::nanoseconds(due_ns - BoxNow()));
  const std::uint64_t trigger = next_++;
  if (silent_.load()) return hal::WaitOutcome::kTimeout;
  frame.stamp = {due_ns, BoxNow(), trigger, side_, base::FrameStatus::kOk};
  frame.image = {picture_.data(), 1400, 1024, 1400, 8};
  delivered_.fetch_add(1);
  return hal::WaitOutcome::kFrame;
}

hal::CameraHealth FakeCamera::Health() const {
  hal::CameraHealth health;
  health.delivered = delivered_.load();
  health.clock_locked = true;
  return health;
}

}  // namespace adit::support
