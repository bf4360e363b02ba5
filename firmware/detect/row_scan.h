// One row of pixels -> one bit a pixel, where any is bright -> where its bright runs begin and end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace adit::detect {

/// 64 neighbouring pixels, some of them bright.
struct LitWord {
  std::uint64_t bright = 0;    ///< bit i: pixel first_px + i; 0 beyond the row
  std::uint32_t first_px = 0;  ///< a multiple of 64
};

/// Writes, from left to right, the words of the row of `width` pixels at `row` that hold any brighter than
/// `threshold`, and returns how many they are. One more may be written.
using RowScan = std::size_t (*)(const std::uint8_t* row, int width, int threshold, LitWord* lit);

/// The straightforward loops, for pixels of one byte and of two, which the others are compared with.
std::size_t ScanRowPlain8(const std::uint8_t* row, int width, int threshold, LitWord* lit);
std::size_t ScanRowPlain16(const std::uint8_t* row, int width, int threshold, LitWord* lit);
/// 64 pixels at a time with the widest instructions of this processor that pay (AVX2, SSE2, NEON).
RowScan FastestRowScan(int bytes_per_pixel);

/// Places of an image that are read in turn. Of 1, 2, 3, 4, 6 and 8 at once, three cost the least with lamps
/// and without: 0.75 to 0.9 times as much as one. Measured on a Zen 3.
constexpr std::size_t kBands = 3;
using Bands = std::array<const std::uint8_t*, kBands>;

/// How many of `count` bytes from each place on, in whole blocks, hold no pixel brighter than `threshold`:
/// the pixels of many rows at once, where these follow one another without a gap.
using DarkScan = std::size_t (*)(const Bands& at, std::size_t count, int threshold);
/// For pixels of that size with the widest instructions of this processor.
DarkScan FastestDarkScan(int bytes_per_pixel);

/// Room that a RowScan wants.
constexpr std::size_t LitWordsRoom(int width) { return (static_cast<std::size_t>(width) + 63) / 64 + 1; }
/// Room that RowEdges wants: two edges a run, and what it writes in advance.
constexpr std::size_t RowEdgesRoom(int width) { return static_cast<std::size_t>(width) + 4; }

/// The bright runs of a scanned row as edges in ascending order: first pixel, pixel after the last, first
/// pixel of the next. Returns how many edges there are.
std::size_t RowEdges(std::span<const LitWord> lit, std::uint16_t* edges);

}  // namespace adit::detect
