#include "firmware/detect/stretch_sums.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace adit::detect {
namespace {

template <typename Pixel>
StretchSums Sum(const std::uint8_t* pixels, int count, int threshold) {
  StretchSums sums;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(count); ++k) {
    Pixel value = 0;
    std::memcpy(&value, pixels + sizeof(Pixel) * k, sizeof(Pixel));
    const std::uint32_t g = value - static_cast<std::uint32_t>(threshold);
    sums.g += g, sums.k += g * k, sums.kk += g * k * k;
    sums.most = std::max<std::uint32_t>(sums.most, value);
  }
  return sums;
}

}  // namespace

StretchSums SumStretchPlain8(const std::uint8_t* pixels, int count, int threshold) {
  return Sum<std::uint8_t>(pixels, count, threshold);
}

StretchSums SumStretchPlain16(const std::uint8_t* pixels, int count, int threshold) {
  return Sum<std::uint16_t>(pixels, count, threshold);
}

#if defined(__x86_64__)

StretchSums SumStretchWide8(const std::uint8_t* pixels, int count, int threshold) {
  static const std::uint8_t taken[2 * kStretchPx] = {255, 255, 255, 255, 255, 255, 255, 255,
                                                     255, 255, 255, 255, 255, 255, 255, 255};
  const auto load = [](const std::uint8_t* p) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
  };
  const __m128i zero = _mm_setzero_si128();
  const __m128i above = _mm_subs_epu8(load(pixels), _mm_set1_epi8(static_cast<char>(threshold)));
  const __m128i g = _mm_and_si128(above, load(taken + kStretchPx - count));
  const __m128i low = _mm_unpacklo_epi8(g, zero), high = _mm_unpackhi_epi8(g, zero);
  const __m128i sum = _mm_sad_epu8(g, zero);  // of either half
  const __m128i k = _mm_add_epi32(_mm_madd_epi16(low, _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7)),
                                  _mm_madd_epi16(high, _mm_setr_epi16(8, 9, 10, 11, 12, 13, 14, 15)));
  const __m128i kk =
      _mm_add_epi32(_mm_madd_epi16(low, _mm_setr_epi16(0, 1, 4, 9, 16, 25, 36, 49)),
                    _mm_madd_epi16(high, _mm_setr_epi16(64, 81, 100, 121, 144, 169, 196, 225)));
  const __m128i pairs = _mm_hadd_epi32(k, kk), sums = _mm_hadd_epi32(pairs, pairs);
  __m128i most = _mm_max_epu8(g, _mm_srli_si128(g, 8));
  most = _mm_max_epu8(most, _mm_srli_si128(most, 4));
  most = _mm_max_epu8(most, _mm_srli_si128(most, 2));
  most = _mm_max_epu8(most, _mm_srli_si128(most, 1));
  const auto lane = [](int value) { return static_cast<std::uint32_t>(value); };
  return {lane(_mm_cvtsi128_si32(sum)) + lane(_mm_extract_epi32(sum, 2)), lane(_mm_cvtsi128_si32(sums)),
          lane(_mm_extract_epi32(sums, 1)), lane(threshold) + (lane(_mm_cvtsi128_si32(most)) & 0xFF)};
}

#else

StretchSums SumStretchWide8(const std::uint8_t* pixels, int count, int threshold) {
  return SumStretchPlain8(pixels, count, threshold);
}

#endif

}  // namespace adit::detect
