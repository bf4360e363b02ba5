#include "drivers/sim/noise.h"

#include <algorithm>
#include <cmath>

#include <CppUTest/TestHarness.h>

using adit::sim::NoiseBank;
using adit::sim::Random;
using adit::sim::Sensor;
using adit::sim::SensorNoise;

namespace {

constexpr std::uint64_t kSeed = 77;
constexpr std::size_t kCount = 400'000;

struct Statistics {
  double mean = 0, variance = 0;
};

template <class Pixel>
Statistics StatisticsOf(const std::vector<Pixel>& pixels) {
  double sum = 0, squares = 0;
  for (const Pixel pixel : pixels) sum += pixel, squares += static_cast<double>(pixel) * pixel;
  const auto count = static_cast<double>(pixels.size());
  return {sum / count, squares / count - sum / count * (sum / count)};
}

template <class Pixel>
std::vector<Pixel> Lit(const Sensor& sensor, float light_dn) {
  const SensorNoise<Pixel> noise(sensor, 0);
  Random random(kSeed);
  const std::vector<float> light(kCount, light_dn);
  std::vector<Pixel> pixels(kCount);
  noise.Fill(random, light.data(), pixels.data(), kCount);
  return pixels;
}

// Five standard errors of a mean and of a variance of kCount normal values.
double MeanTolerance(double variance) { return 5 * std::sqrt(variance / kCount); }
double VarianceTolerance(double variance) { return 5 * variance * std::sqrt(2.0 / kCount); }

}  // namespace

TEST_GROUP(Noise){};

TEST(Noise, OfTheDarkIsBackgroundReadNoiseAndRounding) {
  Sensor sensor;
  sensor.background_dn = 20;  // far from the clip at 0
  const SensorNoise<std::uint8_t> noise(sensor, 3);
  Random random(kSeed);
  std::vector<std::uint8_t> pixels(kCount + 3);
  noise.FillDark(random, pixels.data(), pixels.size());
  const Statistics s = StatisticsOf(pixels);
  const double variance = 1.5 * 1.5 + 1.0 / 12;
  DOUBLES_EQUAL(23, s.mean, MeanTolerance(variance));
  DOUBLES_EQUAL(variance, s.variance, VarianceTolerance(variance));
}

TEST(Noise, OfLightAddsShotNoise) {
  const Sensor sensor;  // 6 DN, 1.5 DN, 40 electrons a DN
  for (const float light_dn : {10.0F, 100.0F, 200.0F}) {
    const Statistics s = StatisticsOf(Lit<std::uint8_t>(sensor, light_dn));
    const double variance = 1.5 * 1.5 + static_cast<double>(light_dn) / 40 + 1.0 / 12;
    DOUBLES_EQUAL(6 + static_cast<double>(light_dn), s.mean, MeanTolerance(variance));
    DOUBLES_EQUAL(variance, s.variance, VarianceTolerance(variance));
  }
}

TEST(Noise, IsDividedFinerBy12Bit) {
  Sensor sensor;
  sensor.bits = 12;
  const Statistics s = StatisticsOf(Lit<std::uint16_t>(sensor, 100));
  const double variance = 256 * (1.5 * 1.5 + 100.0 / 40) + 1.0 / 12;
  DOUBLES_EQUAL(16 * 106.0, s.mean, MeanTolerance(variance));
  DOUBLES_EQUAL(variance, s.variance, VarianceTolerance(variance));
}

TEST(Noise, ClipsAtBothEnds) {
  Sensor sensor;
  const auto clipped = Lit<std::uint8_t>(sensor, 5000);
  CHECK_TRUE(std::all_of(clipped.begin(), clipped.end(), [](std::uint8_t p) { return p == 255; }));
  sensor.bits = 10;
  const auto fine = Lit<std::uint16_t>(sensor, 5000);
  CHECK_TRUE(std::all_of(fine.begin(), fine.end(), [](std::uint16_t p) { return p == 1023; }));
  sensor.bits = 8;
  sensor.background_dn = 0;
  const auto dark = Lit<std::uint8_t>(sensor, 0);
  // Half of a normal distribution about 0, and what of the other half rounds to 0.
  const auto zeros = static_cast<double>(std::count(dark.begin(), dark.end(), 0));
  DOUBLES_EQUAL(0.5 * std::erfc(-0.5 / 1.5 / std::sqrt(2.0)), zeros / kCount, 5 * 0.5 / std::sqrt(kCount));
}

TEST(Noise, IsNormal) {
  const Sensor sensor{16, 0, 1, 1e6, 1, 0, 1};
  const auto pixels = Lit<std::uint16_t>(sensor, 100);  // 256 steps a sigma
  for (const double sigmas : {-3.0, -2.0, -1.0, 0.0, 0.5, 1.5, 2.5, 3.5}) {
    const double below = 0.5 * std::erfc(-sigmas / std::sqrt(2.0));
    const double limit = 256 * (100 + sigmas);
    const auto counted = static_cast<double>(
        std::count_if(pixels.begin(), pixels.end(), [limit](std::uint16_t p) { return p < limit; }));
    DOUBLES_EQUAL(below, counted / kCount, 5 * std::sqrt(below * (1 - below) / kCount) + 1e-3);
  }
}

TEST(Noise, OfNeighboursIsNotCorrelated) {
  Sensor sensor;
  sensor.background_dn = 50;
  const auto pixels = Lit<std::uint8_t>(sensor, 0);
  for (const std::size_t apart : {1U, 2U, 3U, 4U, 1400U}) {
    double sum = 0;
    for (std::size_t i = 0; i + apart < kCount; ++i) sum += (pixels[i] - 50.0) * (pixels[i + apart] - 50.0);
    DOUBLES_EQUAL(0, sum / kCount, 5 * 2.34 / std::sqrt(kCount));
  }
}

TEST(Noise, OfABankIsThatOfTheDarkAtManyPlaces) {
  Sensor sensor;
  sensor.background_dn = 20;
  const SensorNoise<std::uint8_t> noise(sensor, 0);
  const NoiseBank<std::uint8_t> bank(noise, 40'000, kSeed);
  Random random(kSeed);
  const std::uint8_t* const first = bank.Draw(random);
  const std::uint8_t* const second = bank.Draw(random);
  CHECK_TRUE(first != second);
  const Statistics s = StatisticsOf(std::vector<std::uint8_t>(first, first + 40'000));
  DOUBLES_EQUAL(20, s.mean, 5 * std::sqrt(2.34 / 40'000));
  DOUBLES_EQUAL(1.5 * 1.5 + 1.0 / 12, s.variance, 5 * 2.34 * std::sqrt(2.0 / 40'000));
}
