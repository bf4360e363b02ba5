#include "firmware/detect/background.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>

#include "firmware/base/prefetch.h"

namespace adit::detect {
namespace {

// 2800 samples of 1400 x 1024: the median is good to 0.024 sigma. Few rows, because each lies in another page
// of memory: 32 of them took four times as long.
constexpr int kRows = 8, kColumnStep = 4;
constexpr std::size_t kByteLevels = 256, kWideLevels = 4096;  // 12 bit; what is brighter counts as brightest
constexpr double kLowQuantile = 0.1587;  // of a normal distribution, one sigma below the mean

/// Where the cumulative histogram reaches `share`, between the levels by linear interpolation.
double Quantile(std::span<const std::uint32_t> histogram, std::uint32_t count, double share) {
  const double wanted = share * count;
  std::uint32_t below = 0;
  for (std::size_t level = 0; level < histogram.size(); ++level) {
    const std::uint32_t here = histogram[level];
    if (here > 0 && below + here >= wanted) return static_cast<double>(level) - 0.5 + (wanted - below) / here;
    below += here;
  }
  return static_cast<double>(histogram.size() - 1);
}

Background Estimate(std::span<const std::uint32_t> histogram) {
  const std::uint32_t count = std::accumulate(histogram.begin(), histogram.end(), 0U);
  const double level_dn = Quantile(histogram, count, 0.5);
  return {level_dn, std::max(0.0, level_dn - Quantile(histogram, count, kLowQuantile))};
}

/// Calls visit(row, first column) for the rows that are looked at.
template <typename Visit>
void ForEachRow(const base::ImageView& image, const Visit& visit) {
  for (int r = 0; r < kRows; ++r)
    visit(image.Row((2 * r + 1) * image.height_px / (2 * kRows)), r % kColumnStep % image.width_px);
}

/// Neighbours are mostly of one level: counted in four histograms in turn, none waits for the one before.
Background EstimateBytes(const base::ImageView& image) {
  constexpr std::size_t kLanes = 4;
  std::array<std::array<std::uint32_t, kByteLevels>, kLanes> lanes{};
  ForEachRow(image, [&](const std::uint8_t* row, int x) {
    constexpr int kStep = kColumnStep * static_cast<int>(kLanes);
    for (; x + kStep - kColumnStep < image.width_px; x += kStep) {
      for (std::size_t i = 0; i < kLanes; ++i) ++lanes[i][row[x + kColumnStep * static_cast<int>(i)]];
    }
    for (; x < image.width_px; x += kColumnStep) ++lanes[0][row[x]];
  });
  for (std::size_t level = 0; level < kByteLevels; ++level)
    lanes[0][level] += lanes[1][level] + lanes[2][level] + lanes[3][level];
  return Estimate(lanes[0]);
}

Background EstimateWide(const base::ImageView& image) {
  std::array<std::uint32_t, kWideLevels> histogram{};
  ForEachRow(image, [&](const std::uint8_t* row, int x) {
    for (; x < image.width_px; x += kColumnStep) {
      std::uint16_t value = 0;
      std::memcpy(&value, row + std::ptrdiff_t{2} * x, sizeof(value));
      ++histogram[std::min<std::size_t>(value, kWideLevels - 1)];
    }
  });
  return Estimate(histogram);
}

}  // namespace

Background EstimateBackground(const base::ImageView& image) {
  ForEachRow(image, [&](const std::uint8_t* row, int) {
    base::Prefetch(row, std::ptrdiff_t{image.width_px} * image.BytesPerPixel());
  });
  return image.BytesPerPixel() == 1 ? EstimateBytes(image) : EstimateWide(image);
}

}  // namespace adit::detect
