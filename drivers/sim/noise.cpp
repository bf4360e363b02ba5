#include "drivers/sim/noise.h"

#include <cmath>
#include <numbers>

namespace adit::sim {
namespace {

constexpr std::size_t kQuantiles = 65536;  // 16 random bits a pixel

/// The middles of kQuantiles equally probable parts of N(0, 1), scaled to a variance of exactly 1.
std::vector<float> NormalQuantiles() {
  std::vector<double> upper;  // of the upper half, from the middle outwards
  double x = 0, squares = 0;
  for (std::size_t i = 0; i < kQuantiles / 2; ++i) {
    const double tail = 0.5 - (static_cast<double>(i) + 0.5) / kQuantiles;
    // Newton on the upper tail, from the neighbour before: converges at once but at the far end.
    for (int step = 0; step < 6; ++step) {
      const double miss = 0.5 * std::erfc(x / std::numbers::sqrt2) - tail;
      x += miss / (std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi));
    }
    upper.push_back(x);
    squares += 2 * x * x;
  }
  const double stretch = std::sqrt(kQuantiles / squares);
  std::vector<float> quantiles;
  for (auto q = upper.rbegin(); q != upper.rend(); ++q)
    quantiles.push_back(static_cast<float>(-*q * stretch));
  for (const double q : upper) quantiles.push_back(static_cast<float>(q * stretch));
  return quantiles;
}

}  // namespace

template <class Pixel>
SensorNoise<Pixel>::SensorNoise(const Sensor& sensor, double veil_dn)
    : normal_(NormalQuantiles()),
      background_dn_(static_cast<float>(sensor.background_dn + veil_dn)),
      read_variance_(static_cast<float>(sensor.read_noise_dn * sensor.read_noise_dn)),
      dn_per_electron_(static_cast<float>(1 / sensor.electrons_per_dn)),
      scale_(static_cast<float>(1 << (sensor.bits - 8))),
      brightest_(static_cast<float>((1 << sensor.bits) - 1)) {
  const auto read_noise_dn = static_cast<float>(sensor.read_noise_dn);
  for (const float q : normal_) dark_.push_back(Quantise(background_dn_ + read_noise_dn * q));
}

template <class Pixel>
Pixel SensorNoise<Pixel>::Quantise(float dn) const {
  const float value = std::min(std::max(dn * scale_ + 0.5F, 0.0F), brightest_);
  return static_cast<Pixel>(static_cast<int>(value));
}

template <class Pixel>
void SensorNoise<Pixel>::FillDark(Random& random, Pixel* pixels, std::size_t count) const {
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const std::uint64_t bits = random.Next();
    pixels[i] = dark_[bits & 0xffff];
    pixels[i + 1] = dark_[(bits >> 16) & 0xffff];
    pixels[i + 2] = dark_[(bits >> 32) & 0xffff];
    pixels[i + 3] = dark_[bits >> 48];
  }
  for (; i < count; ++i) pixels[i] = dark_[random.Next() & 0xffff];
}

template <class Pixel>
void SensorNoise<Pixel>::Fill(Random& random, const float* light, Pixel* pixels, std::size_t count) const {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    bits = i % 4 == 0 ? random.Next() : bits >> 16;
    const float sigma_dn = std::sqrt(read_variance_ + light[i] * dn_per_electron_);
    pixels[i] = Quantise(background_dn_ + light[i] + sigma_dn * normal_[bits & 0xffff]);
  }
}

template <class Pixel>
NoiseBank<Pixel>::NoiseBank(const SensorNoise<Pixel>& noise, std::size_t frame_pixels, std::uint64_t seed)
    : pixels_((kFrames + 1) * frame_pixels), starts_(kFrames * frame_pixels) {
  Random random(seed, 0x62616e6b);
  noise.FillDark(random, pixels_.data(), pixels_.size());
}

template <class Pixel>
const Pixel* NoiseBank<Pixel>::Draw(Random& random) const {
  return pixels_.data() + random.Next() % starts_;
}

template class SensorNoise<std::uint8_t>;
template class SensorNoise<std::uint16_t>;
template class NoiseBank<std::uint8_t>;
template class NoiseBank<std::uint16_t>;

}  // namespace adit::sim
