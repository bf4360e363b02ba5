// Sums over a few pixels side by side: what the moments of a spot are made of.
#pragma once

#include <cstdint>

namespace adit::detect {

/// Pixels that one call takes: one or two make an LED's run.
inline constexpr int kStretchPx = 16;

/// Of pixels k = 0, 1, ... with the values I_k, all brighter than the threshold t: whole numbers, in the
/// image's own DN.
struct StretchSums {
  std::uint32_t g = 0;     ///< sum of I_k - t
  std::uint32_t k = 0;     ///< sum of k (I_k - t)
  std::uint32_t kk = 0;    ///< sum of k^2 (I_k - t): 16 bits times 1240 stay within 32
  std::uint32_t most = 0;  ///< the largest I_k
};

/// The first `count` (1 to kStretchPx) of the pixels, one byte each or two. The straightforward loops.
StretchSums SumStretchPlain8(const std::uint8_t* pixels, int count, int threshold);
StretchSums SumStretchPlain16(const std::uint8_t* pixels, int count, int threshold);
/// As SumStretchPlain8, but kStretchPx bytes must be readable: a few wide instructions, whatever the count.
StretchSums SumStretchWide8(const std::uint8_t* pixels, int count, int threshold);

}  // namespace adit::detect
