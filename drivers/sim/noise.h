// What a sensor makes of light: shot noise, read noise, rounding, clipping.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/sim/canvas.h"
#include "drivers/sim/random.h"
#include "drivers/sim/scene.h"

namespace adit::sim {

/// Turns light (DN of 8 bit above the background) into pixels of `Pixel` (std::uint8_t, or std::uint16_t for
/// more than 8 bits): value = background + light + N(0, read_noise^2 + light / electrons_per_dn), rounded and
/// clipped. Shot noise is normal, not Poisson: at 40 electrons a DN the difference drowns in the read noise.
/// The normal numbers come out of a table of 65536 quantiles: they end at 4.3 sigma. Immutable; any thread.
template <class Pixel>
class SensorNoise {
 public:
  SensorNoise(const Sensor& sensor, double veil_dn);

  /// `count` pixels of background alone.
  void FillDark(Random& random, Pixel* pixels, std::size_t count) const;
  /// `count` pixels that receive `light`.
  void Fill(Random& random, const float* light, Pixel* pixels, std::size_t count) const;

 private:
  Pixel Quantise(float dn) const;

  std::vector<float> normal_;  ///< quantiles of N(0, 1)
  std::vector<Pixel> dark_;    ///< the pixel of each quantile without light
  float background_dn_, read_variance_, dn_per_electron_;
  float scale_;  ///< DN of the sensor's bits in one of 8 bit
  float brightest_;
};

/// Frames of background noise made ahead, as one run of pixels: any stretch of it is a new frame, as long as
/// nobody compares it with another.
template <class Pixel>
class NoiseBank {
 public:
  NoiseBank(const SensorNoise<Pixel>& noise, std::size_t frame_pixels, std::uint64_t seed);
  /// The start of `frame_pixels` pixels, at a random place.
  const Pixel* Draw(Random& random) const;

 private:
  static constexpr std::size_t kFrames = 16;
  std::vector<Pixel> pixels_;
  std::size_t starts_;
};

extern template class SensorNoise<std::uint8_t>;
extern template class SensorNoise<std::uint16_t>;
extern template class NoiseBank<std::uint8_t>;
extern template class NoiseBank<std::uint16_t>;

}  // namespace adit::sim
