#include "firmware/detect/row_scan.h"

#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace adit::detect {
namespace {

constexpr int kWord = 64;  // pixels

template <typename Pixel>
bool ScanPlain(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  std::uint64_t any = 0;
  for (int x = 0; x < width; x += kWord) {
    std::uint64_t word = 0;
    for (int i = 0; i < kWord && x + i < width; ++i) {
      Pixel value = 0;
      std::memcpy(&value, row + static_cast<std::ptrdiff_t>(sizeof(Pixel)) * (x + i), sizeof(Pixel));
      word |= static_cast<std::uint64_t>(value > threshold) << i;
    }
    *bright++ = word;
    any |= word;
  }
  return any != 0;
}

// The scans below have one shape: whole words, then the word of the row's last 64 pixels, shifted. They want
// rows of at least 64 pixels. A saturated subtraction leaves 0 where a pixel is not brighter.

#if defined(__x86_64__)

std::uint64_t DarkSse2(__m128i rest) {
  return static_cast<std::uint64_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(rest, _mm_setzero_si128())));
}

bool ScanSse2x8(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  const __m128i limit = _mm_set1_epi8(static_cast<char>(threshold));
  const auto word = [&](int x) {
    const auto* const p = reinterpret_cast<const __m128i*>(row + x);
    const auto rest = [&](int i) { return _mm_subs_epu8(_mm_loadu_si128(p + i), limit); };
    return ~(DarkSse2(rest(0)) | DarkSse2(rest(1)) << 16 | DarkSse2(rest(2)) << 32 | DarkSse2(rest(3)) << 48);
  };
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = word(x);
  if (x < width) any |= * bright = word(width - kWord) >> (x + kWord - width);
  return any != 0;
}

bool ScanSse2x16(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  const __m128i limit = _mm_set1_epi16(static_cast<short>(threshold)), zero = _mm_setzero_si128();
  const auto word = [&](int x) {
    const auto* const p = reinterpret_cast<const __m128i*>(row + std::ptrdiff_t{2} * x);
    const auto dark = [&](int i) {
      return _mm_cmpeq_epi16(_mm_subs_epu16(_mm_loadu_si128(p + i), limit), zero);
    };
    const auto bits = [&](int i) {
      return static_cast<std::uint64_t>(_mm_movemask_epi8(_mm_packs_epi16(dark(2 * i), dark(2 * i + 1))));
    };
    return ~(bits(0) | bits(1) << 16 | bits(2) << 32 | bits(3) << 48);
  };
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = word(x);
  if (x < width) any |= * bright = word(width - kWord) >> (x + kWord - width);
  return any != 0;
}

__attribute__((target("avx2"))) std::uint64_t DarkAvx2(__m256i rest) {
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(rest, _mm256_setzero_si256())));
}

__attribute__((target("avx2"))) std::uint64_t WordAvx2x8(const std::uint8_t* at, __m256i limit) {
  const auto* const p = reinterpret_cast<const __m256i*>(at);
  return ~(DarkAvx2(_mm256_subs_epu8(_mm256_loadu_si256(p), limit)) |
           DarkAvx2(_mm256_subs_epu8(_mm256_loadu_si256(p + 1), limit)) << 32);
}

__attribute__((target("avx2"))) bool ScanAvx2x8(const std::uint8_t* row, int width, int threshold,
                                                std::uint64_t* bright) {
  const __m256i limit = _mm256_set1_epi8(static_cast<char>(threshold));
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = WordAvx2x8(row + x, limit);
  if (x < width) any |= * bright = WordAvx2x8(row + width - kWord, limit) >> (x + kWord - width);
  return any != 0;
}

__attribute__((target("avx2"))) std::uint64_t WordAvx2x16(const std::uint8_t* at, __m256i limit) {
  const auto* const p = reinterpret_cast<const __m256i*>(at);
  std::uint64_t dark = 0;
  for (int i = 0; i < 2; ++i) {
    const __m256i zero = _mm256_setzero_si256();
    const __m256i a = _mm256_cmpeq_epi16(_mm256_subs_epu16(_mm256_loadu_si256(p + 2 * i), limit), zero);
    const __m256i b = _mm256_cmpeq_epi16(_mm256_subs_epu16(_mm256_loadu_si256(p + 2 * i + 1), limit), zero);
    // Packing works within halves: 0 2 1 3 puts the quarters back in order.
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packs_epi16(a, b), 0b11'01'10'00);
    dark |= static_cast<std::uint64_t>(static_cast<std::uint32_t>(_mm256_movemask_epi8(packed))) << (32 * i);
  }
  return ~dark;
}

__attribute__((target("avx2"))) bool ScanAvx2x16(const std::uint8_t* row, int width, int threshold,
                                                 std::uint64_t* bright) {
  const __m256i limit = _mm256_set1_epi16(static_cast<short>(threshold));
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = WordAvx2x16(row + std::ptrdiff_t{2} * x, limit);
  if (x < width) {
    const std::uint8_t* const last = row + std::ptrdiff_t{2} * (width - kWord);
    any |= * bright = WordAvx2x16(last, limit) >> (x + kWord - width);
  }
  return any != 0;
}

#elif defined(__aarch64__)

/// One bit of each of 64 bytes that are all ones or all zeros.
std::uint64_t BitsNeon(uint8x16_t a, uint8x16_t b, uint8x16_t c, uint8x16_t d) {
  const uint8x16_t weight = vreinterpretq_u8_u64(vdupq_n_u64(0x8040201008040201));
  const uint8x16_t ab = vpaddq_u8(vandq_u8(a, weight), vandq_u8(b, weight));
  const uint8x16_t cd = vpaddq_u8(vandq_u8(c, weight), vandq_u8(d, weight));
  const uint8x16_t abcd = vpaddq_u8(ab, cd);
  return vgetq_lane_u64(vreinterpretq_u64_u8(vpaddq_u8(abcd, abcd)), 0);
}

bool ScanNeon8(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  const uint8x16_t limit = vdupq_n_u8(static_cast<std::uint8_t>(threshold));
  const auto word = [&](int x) {
    const auto above = [&](int i) { return vcgtq_u8(vld1q_u8(row + x + 16 * i), limit); };
    return BitsNeon(above(0), above(1), above(2), above(3));
  };
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = word(x);
  if (x < width) any |= * bright = word(width - kWord) >> (x + kWord - width);
  return any != 0;
}

bool ScanNeon16(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  const uint16x8_t limit = vdupq_n_u16(static_cast<std::uint16_t>(threshold));
  const auto word = [&](int x) {
    const auto half = [&](int i) {
      const std::uint8_t* const p = row + std::ptrdiff_t{2} * (x + 8 * i);
      return vmovn_u16(vcgtq_u16(vreinterpretq_u16_u8(vld1q_u8(p)), limit));
    };
    const auto above = [&](int i) { return vcombine_u8(half(2 * i), half(2 * i + 1)); };
    return BitsNeon(above(0), above(1), above(2), above(3));
  };
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = word(x);
  if (x < width) any |= * bright = word(width - kWord) >> (x + kWord - width);
  return any != 0;
}

#endif

/// Rows too short for a whole word, by the plain loop.
template <RowScan kLong, RowScan kShort>
bool ScanRow(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  return width < kWord ? kShort(row, width, threshold, bright) : kLong(row, width, threshold, bright);
}

}  // namespace

bool ScanRowPlain8(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  return ScanPlain<std::uint8_t>(row, width, threshold, bright);
}

bool ScanRowPlain16(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  return ScanPlain<std::uint16_t>(row, width, threshold, bright);
}

RowScan FastestRowScan(int bytes_per_pixel) {
  const bool bytes = bytes_per_pixel == 1;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2"))
    return bytes ? ScanRow<ScanAvx2x8, ScanRowPlain8> : ScanRow<ScanAvx2x16, ScanRowPlain16>;
  return bytes ? ScanRow<ScanSse2x8, ScanRowPlain8> : ScanRow<ScanSse2x16, ScanRowPlain16>;
#elif defined(__aarch64__)
  return bytes ? ScanRow<ScanNeon8, ScanRowPlain8> : ScanRow<ScanNeon16, ScanRowPlain16>;
#else
  return bytes ? ScanRowPlain8 : ScanRowPlain16;
#endif
}

std::size_t RowEdges(std::span<const std::uint64_t> bright, std::uint16_t* edges) {
  const std::uint16_t* const first = edges;
  std::uint64_t before = 0;  // the pixel left of the word
  unsigned x = 0;
  for (const std::uint64_t word : bright) {
    std::uint64_t changes = word ^ (word << 1 | before);
    before = word >> (kWord - 1);
    for (; changes != 0; changes &= changes - 1)
      *edges++ = static_cast<std::uint16_t>(x + static_cast<unsigned>(std::countr_zero(changes)));
    x += kWord;
  }
  if (before != 0) *edges++ = static_cast<std::uint16_t>(x);  // open at the end of a row of whole words
  return static_cast<std::size_t>(edges - first);
}

}  // namespace adit::detect
