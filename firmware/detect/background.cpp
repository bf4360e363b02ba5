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

// 1400 samples of 1400 x 1024: the median is good to 0.034 sigma. Few rows, because each lies in another page
// of memory, and of these every eighth piece: pieces apart are as many lines of memory as they are pieces.
constexpr int kRows = 8, kPiecePx = 32, kPieceStep = 8;
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

/// Calls visit(first pixel, count) for the pieces of rows that are looked at: no column is left out by all.
template <typename Visit>
void ForEachPiece(const base::ImageView& image, const Visit& visit) {
  for (int r = 0; r < kRows; ++r) {
    const std::uint8_t* const row = image.Row((2 * r + 1) * image.height_px / (2 * kRows));
    for (int x = r % kPieceStep * kPiecePx; x < image.width_px; x += kPieceStep * kPiecePx)
      visit(row + std::ptrdiff_t{x} * image.BytesPerPixel(), std::min(kPiecePx, image.width_px - x));
  }
}

/// Neighbours are mostly of one level: counted in four histograms in turn, none waits for the one before.
Background EstimateBytes(const base::ImageView& image) {
  constexpr int kLanes = 4;
  std::array<std::array<std::uint32_t, kByteLevels>, kLanes> lanes{};
  ForEachPiece(image, [&](const std::uint8_t* pixels, int count) {
    for (; count >= kLanes; count -= kLanes, pixels += kLanes) {
      for (std::size_t i = 0; i < kLanes; ++i) ++lanes[i][pixels[i]];
    }
    for (; count > 0; --count) ++lanes[0][*pixels++];
  });
  for (std::size_t level = 0; level < kByteLevels; ++level)
    lanes[0][level] += lanes[1][level] + lanes[2][level] + lanes[3][level];
  return Estimate(lanes[0]);
}

Background EstimateWide(const base::ImageView& image) {
  std::array<std::uint32_t, kWideLevels> histogram{};
  ForEachPiece(image, [&](const std::uint8_t* pixels, int count) {
    for (std::uint16_t value = 0; count > 0; --count, pixels += sizeof(value)) {
      std::memcpy(&value, pixels, sizeof(value));
      ++histogram[std::min<std::size_t>(value, kWideLevels - 1)];
    }
  });
  return Estimate(histogram);
}

}  // namespace

void FetchBackground(const base::ImageView& image) {
  ForEachPiece(image, [&](const std::uint8_t* pixels, int count) {
    base::Prefetch(pixels, std::ptrdiff_t{count} * image.BytesPerPixel());
  });
}

Background EstimateBackground(const base::ImageView& image) {
  return image.BytesPerPixel() == 1 ? EstimateBytes(image) : EstimateWide(image);
}

}  // namespace adit::detect
