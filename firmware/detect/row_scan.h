// One row of pixels -> runs of bright ones.
#pragma once

#include <cstddef>
#include <cstdint>

namespace adit::detect {

/// Bright pixels [begin_px, end_px) of row y_px, touching neither neighbour of the row that is bright.
struct Run {
  std::uint16_t begin_px, end_px, y_px;
};

/// Writes the runs of pixels brighter than `threshold` among the `width` ones at `row`, at most `room` of
/// them, to `out`. Returns how many there are; more than `room` means that the rest is missing.
using RowScan = std::size_t (*)(const std::uint8_t* row, int width, int threshold, Run* out,
                                std::size_t room);

/// The straightforward loop, which the others are compared with.
std::size_t ScanRowPlain(const std::uint8_t* row, int width, int threshold, Run* out, std::size_t room);
/// The same for 16 bit pixels.
std::size_t ScanRowPlain16(const std::uint8_t* row, int width, int threshold, Run* out, std::size_t room);
/// 64 pixels at a time with the processor's widest instructions that pay (SSE2, AVX2).
RowScan FastestRowScan();

}  // namespace adit::detect
