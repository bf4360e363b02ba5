// A camera that a test commands: the same picture at every trigger of an ideal clock.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "hal/camera.h"
#include "tests/support/synthetic_bar.h"

namespace adit::support {

/// Spots of a bar on a dark image, as one camera sees them.
std::vector<std::uint8_t> DrawBar(const SyntheticCamera& camera, const SyntheticBar& bar);

class FakeCamera final : public hal::Camera {
 public:
  FakeCamera(base::Side side, double rate_hz, std::vector<std::uint8_t> picture);

  /// Trigger n comes at `start_ns` + n periods of the box clock. Until Run, nothing comes.
  void Run(base::TimeNs start_ns) { start_ns_.store(start_ns); }
  /// No frames while silent; triggers count on.
  void Silence(bool silent) { silent_.store(silent); }

  base::Result<void> Start() override { return {}; }
  hal::WaitOutcome Wait(base::DurationNs timeout_ns, base::CameraFrame& frame) override;
  void Release(const base::CameraFrame&) override { released_.fetch_add(1); }
  hal::CameraHealth Health() const override;
  std::string Name() const override { return "fake"; }
  void Stop() override {}

  std::uint64_t Delivered() const { return delivered_.load(); }
  std::uint64_t Released() const { return released_.load(); }

 private:
  base::Side side_;
  base::DurationNs period_ns_;
  std::vector<std::uint8_t> picture_;
  std::atomic<base::TimeNs> start_ns_{base::kNever};
  std::atomic<bool> silent_{false};
  std::atomic<std::uint64_t> delivered_{0}, released_{0};
  std::uint64_t next_ = 0;
};

}  // namespace adit::support
