// One camera of a simulated world, as a driver would deliver its frames.
#pragma once

#include <vector>

#include "drivers/sim/renderer.h"
#include "drivers/sim/world.h"
#include "firmware/base/image.h"

namespace adit::host {

class SimulatedCamera {
 public:
  /// `world` must outlive this.
  SimulatedCamera(const sim::World& world, base::Side side)
      : world_(world), side_(side), renderer_(world, side, sim::NoiseSource::kFresh) {
    pixels_.resize(renderer_.FrameBytes());
  }

  /// The frame of this trigger; its pixels are valid until the next call.
  base::CameraFrame Expose(std::uint64_t trigger);

 private:
  const sim::World& world_;
  base::Side side_;
  sim::Renderer renderer_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace adit::host
