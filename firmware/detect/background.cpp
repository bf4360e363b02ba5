#include "firmware/detect/background.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <numeric>

#include "firmware/base/prefetch.h"

namespace adit::detect {
namespace {

// 2800 samples of 1400 x 1024: the median is good to 0.024 sigma. Few rows, because each lies in another page
// of memory: 32 of them took four times as long.
constexpr int kRows = 8, kColumnStep = 4;
constexpr int kLevels = 4096;            // 12 bit; what is brighter counts as brightest
constexpr double kLowQuantile = 0.1587;  // of a normal distribution, one sigma below the mean

using Histogram = std::array<std::uint32_t, kLevels>;

/// Where the cumulative histogram reaches `share`, between the levels by linear interpolation.
double Quantile(const Histogram& histogram, std::uint32_t count, double share) {
  const double wanted = share * count;
  double below = 0;
  for (int level = 0; level < kLevels; ++level) {
    const double here = histogram[static_cast<std::size_t>(level)];
    if (here > 0 && below + here >= wanted) return level - 0.5 + (wanted - below) / here;
    below += here;
  }
  return kLevels - 1;
}

constexpr std::size_t kByteLevels = 256, kLanes = 4;  // four histograms of bytes in one

/// Neighbours are mostly of one level: counted in four histograms in turn, none waits for the one before.
void Count(const std::uint8_t* row, int first_px, int width_px, Histogram& histogram) {
  std::size_t lane = 0;
  for (int x = first_px; x < width_px; x += kColumnStep) {
    ++histogram[lane + row[x]];
    lane = (lane + kByteLevels) % (kByteLevels * kLanes);
  }
}

void FoldLanes(Histogram& histogram) {
  for (std::size_t i = kByteLevels; i < kByteLevels * kLanes; ++i) {
    histogram[i % kByteLevels] += histogram[i];
    histogram[i] = 0;
  }
}

void CountWide(const std::uint8_t* row, int first_px, int width_px, Histogram& histogram) {
  for (int x = first_px; x < width_px; x += kColumnStep) {
    std::uint16_t value = 0;
    std::memcpy(&value, row + 2 * x, sizeof(value));
    ++histogram[std::min<std::size_t>(value, kLevels - 1)];
  }
}

}  // namespace

Background EstimateBackground(const base::ImageView& image) {
  const auto row_of = [&](int r) { return image.Row((2 * r + 1) * image.height_px / (2 * kRows)); };
  for (int r = 0; r < kRows; ++r)
    base::Prefetch(row_of(r), std::ptrdiff_t{image.width_px} * image.BytesPerPixel());
  Histogram histogram{};
  const bool wide = image.BytesPerPixel() == 2;
  for (int r = 0; r < kRows; ++r)
    (wide ? CountWide : Count)(row_of(r), r % kColumnStep % image.width_px, image.width_px, histogram);
  if (!wide) FoldLanes(histogram);
  const std::uint32_t count = std::accumulate(histogram.begin(), histogram.end(), 0U);
  const double level_dn = Quantile(histogram, count, 0.5);
  return {level_dn, std::max(0.0, level_dn - Quantile(histogram, count, kLowQuantile))};
}

}  // namespace adit::detect
