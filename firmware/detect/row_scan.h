// One row of pixels -> one bit a pixel -> where its bright runs begin and end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace adit::detect {

/// Bit i of word w of `bright` tells whether pixel 64 w + i of the `width` ones at `row` is brighter than
/// `threshold`; the last word's bits beyond the row are 0. False if no pixel is: then the words need not be
/// looked at.
using RowScan = bool (*)(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright);

/// The straightforward loops, for pixels of one byte and of two, which the others are compared with.
bool ScanRowPlain8(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright);
bool ScanRowPlain16(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright);
/// 64 pixels at a time with the widest instructions of this processor that pay (AVX2, SSE2, NEON).
RowScan FastestRowScan(int bytes_per_pixel);

constexpr std::size_t RowWords(int width) { return (static_cast<std::size_t>(width) + 63) / 64; }
/// Room that RowEdges wants: two edges a run, and what it writes in advance.
constexpr std::size_t RowEdgesRoom(int width) { return static_cast<std::size_t>(width) + 4; }

/// The bright runs of a scanned row as edges in ascending order: first pixel, pixel after the last, first
/// pixel of the next. Returns how many edges there are.
std::size_t RowEdges(std::span<const std::uint64_t> bright, std::uint16_t* edges);

}  // namespace adit::detect
