// Frames of one camera of a world.
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/sim/world.h"
#include "firmware/base/image.h"

namespace adit::sim {

enum class NoiseSource : std::uint8_t {
  /// Every pixel of every frame draws its own noise. For recordings.
  kFresh,
  /// Dark pixels take theirs from a bank of frames made ahead, at a random place; lit ones draw their own.
  /// Real
  /// enough to detect in, not to measure the noise of the background between frames. For live streams.
  kBank,
};

/// Renders one side. A frame depends on scene, seed, side, trigger and noise source alone: not on which
/// frames were rendered before, nor on the thread. One thread at a time.
class Renderer {
 public:
  /// `world` must outlive the renderer. The bank takes 17 frames of memory.
  Renderer(const World& world, base::Side side, NoiseSource source);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Bytes of a frame: one a pixel for 8 bits, else two (host order), without gaps.
  std::size_t FrameBytes() const;
  /// Fills `pixels` (FrameBytes of them; aligned for two bytes if there are two a pixel).
  void Render(std::uint64_t trigger, std::uint8_t* pixels);
  /// The noise-free light above the background at the trigger, row by row, in DN of 8 bit, unclipped. For
  /// tests and for bounds.
  std::vector<float> Light(std::uint64_t trigger);

 private:
  template <class Pixel>
  struct Develop;
  struct Still;

  void Expose(std::uint64_t trigger);
  void AddMoving(std::size_t light, double t_s, double factor);
  void AddDisc(const Reception& seen, double share, Canvas& canvas) const;
  const Canvas& StillOf(std::size_t light, const Reception& seen);

  const World& world_;
  base::Side side_;
  Canvas canvas_;
  std::vector<std::unique_ptr<Still>> stills_;  ///< of lights at rest, made when first seen
  std::unique_ptr<Develop<std::uint8_t>> develop8_;
  std::unique_ptr<Develop<std::uint16_t>> develop16_;
};

}  // namespace adit::sim
