// A scene as two cameras see it, frame by frame: what simulated cameras serve.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/sim/renderer.h"
#include "drivers/sim/truth_file.h"

namespace adit::sim {

/// Owns the world and a renderer a side. The two sides may render in two threads at once; Truth in any.
class LiveScene {
 public:
  /// Reads the scene file. Declines as LoadScene does.
  static base::Result<std::unique_ptr<LiveScene>> Open(const std::string& path, NoiseSource source);
  LiveScene(Scene scene, NoiseSource source);

  const World& GetWorld() const { return world_; }
  const Scene& GetScene() const { return world_.GetScene(); }
  /// Bytes of one frame of that side, and the same as width, height and bits.
  std::size_t FrameBytes(base::Side side) const { return Pick(side).FrameBytes(); }
  int WidthPx(base::Side side) const { return world_.Camera(side).width_px; }
  int HeightPx(base::Side side) const { return world_.Camera(side).height_px; }
  int Bits() const { return world_.GetScene().sensor.bits; }

  /// Fills FrameBytes(side) bytes with the frame of that trigger; any trigger, in any order.
  void Render(base::Side side, std::uint64_t trigger, std::uint8_t* pixels) {
    (side == base::Side::kLeft ? left_ : right_).Render(trigger, pixels);
  }
  std::vector<TruthRow> Truth(std::uint64_t trigger) const { return TruthRows(world_, trigger); }

 private:
  const Renderer& Pick(base::Side side) const { return side == base::Side::kLeft ? left_ : right_; }

  World world_;
  Renderer left_, right_;
};

}  // namespace adit::sim
