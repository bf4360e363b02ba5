#include "firmware/detect/row_scan.h"

#include <bit>
#include <cstring>

#include "firmware/detect/avx2.h"

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

// The scans below have one shape: whole words, then the word of the row's last 64 pixels, shifted; a row
// shorter than that is its first and its last 32 pixels. Each is made of what gives the bits of 32 pixels. A
// saturated subtraction leaves 0 where a pixel is not brighter.
constexpr int kHalf = kWord / 2;

template <typename Half>
bool Scan(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  const auto limit = Half::Limit(threshold);
  const auto half = [&](int x) { return Half::Bits(row + std::ptrdiff_t{Half::kPixelBytes} * x, limit); };
  const auto word = [&](int x) { return half(x) | half(x + kHalf) << kHalf; };
  if (width < kWord) return (*bright = half(0) | half(width - kHalf) << (width - kHalf)) != 0;
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord) any |= * bright++ = word(x);
  if (x < width) any |= * bright = word(width - kWord) >> (x + kWord - width);
  return any != 0;
}

#if defined(__x86_64__)

std::uint64_t BitsOf(__m128i bytes) { return static_cast<std::uint32_t>(_mm_movemask_epi8(bytes)); }

struct Sse2x8 {
  static constexpr int kPixelBytes = 1;
  static __m128i Limit(int threshold) { return _mm_set1_epi8(static_cast<char>(threshold)); }
  static std::uint64_t Bits(const std::uint8_t* at, __m128i limit) {
    const auto dark = [&](int i) {
      const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at) + i);
      return BitsOf(_mm_cmpeq_epi8(_mm_subs_epu8(pixels, limit), _mm_setzero_si128()));
    };
    return (dark(0) | dark(1) << 16) ^ 0xFFFF'FFFF;
  }
};

struct Sse2x16 {
  static constexpr int kPixelBytes = 2;
  static __m128i Limit(int threshold) { return _mm_set1_epi16(static_cast<short>(threshold)); }
  static std::uint64_t Bits(const std::uint8_t* at, __m128i limit) {
    const auto dark = [&](int i) {
      const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at) + i);
      return _mm_cmpeq_epi16(_mm_subs_epu16(pixels, limit), _mm_setzero_si128());
    };
    const std::uint64_t first = BitsOf(_mm_packs_epi16(dark(0), dark(1)));
    return (first | BitsOf(_mm_packs_epi16(dark(2), dark(3))) << 16) ^ 0xFFFF'FFFF;
  }
};

ADIT_AVX2 std::uint64_t BitsOf(__m256i bytes) {
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(bytes));
}

struct Avx2x8 {
  static constexpr int kPixelBytes = 1;
  ADIT_AVX2 static __m256i Limit(int threshold) { return _mm256_set1_epi8(static_cast<char>(threshold)); }
  ADIT_AVX2 static std::uint64_t Bits(const std::uint8_t* at, __m256i limit) {
    const __m256i pixels = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
    const __m256i rest = _mm256_subs_epu8(pixels, limit);
    return BitsOf(_mm256_cmpeq_epi8(rest, _mm256_setzero_si256())) ^ 0xFFFF'FFFF;
  }
};

struct Avx2x16 {
  static constexpr int kPixelBytes = 2;
  ADIT_AVX2 static __m256i Limit(int threshold) { return _mm256_set1_epi16(static_cast<short>(threshold)); }
  ADIT_AVX2 static std::uint64_t Bits(const std::uint8_t* at, __m256i limit) {
    const auto* const p = reinterpret_cast<const __m256i*>(at);
    const __m256i zero = _mm256_setzero_si256();
    const __m256i a = _mm256_cmpeq_epi16(_mm256_subs_epu16(_mm256_loadu_si256(p), limit), zero);
    const __m256i b = _mm256_cmpeq_epi16(_mm256_subs_epu16(_mm256_loadu_si256(p + 1), limit), zero);
    // Packing works within halves: 0 2 1 3 puts the quarters back in order.
    return BitsOf(_mm256_permute4x64_epi64(_mm256_packs_epi16(a, b), 0b11'01'10'00)) ^ 0xFFFF'FFFF;
  }
};

/// Scan again, without lambdas: those would not be compiled for AVX2.
template <typename Half>
ADIT_AVX2 bool ScanAvx2(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  constexpr std::ptrdiff_t kHalfBytes = Half::kPixelBytes * kHalf;
  const __m256i limit = Half::Limit(threshold);
  const std::uint8_t* const last = row + std::ptrdiff_t{Half::kPixelBytes} * width - kHalfBytes;
  if (width < kWord)
    return (*bright = Half::Bits(row, limit) | Half::Bits(last, limit) << (width - kHalf)) != 0;
  std::uint64_t any = 0;
  int x = 0;
  for (; x + kWord <= width; x += kWord, row += 2 * kHalfBytes)
    any |= * bright++ = Half::Bits(row, limit) | Half::Bits(row + kHalfBytes, limit) << kHalf;
  if (x < width) {
    const std::uint64_t word = Half::Bits(last - kHalfBytes, limit) | Half::Bits(last, limit) << kHalf;
    any |= * bright = word >> (x + kWord - width);
  }
  return any != 0;
}

#elif defined(__aarch64__)

/// One bit of each of 32 bytes that are all ones or all zeros.
std::uint64_t BitsOf(uint8x16_t a, uint8x16_t b) {
  const uint8x16_t weight = vreinterpretq_u8_u64(vdupq_n_u64(0x8040201008040201));
  const uint8x16_t ab = vpaddq_u8(vandq_u8(a, weight), vandq_u8(b, weight));
  const uint8x16_t quarters = vpaddq_u8(ab, ab);
  return vgetq_lane_u32(vreinterpretq_u32_u8(vpaddq_u8(quarters, quarters)), 0);
}

struct Neon8 {
  static constexpr int kPixelBytes = 1;
  static uint8x16_t Limit(int threshold) { return vdupq_n_u8(static_cast<std::uint8_t>(threshold)); }
  static std::uint64_t Bits(const std::uint8_t* at, uint8x16_t limit) {
    return BitsOf(vcgtq_u8(vld1q_u8(at), limit), vcgtq_u8(vld1q_u8(at + 16), limit));
  }
};

struct Neon16 {
  static constexpr int kPixelBytes = 2;
  static uint16x8_t Limit(int threshold) { return vdupq_n_u16(static_cast<std::uint16_t>(threshold)); }
  static std::uint64_t Bits(const std::uint8_t* at, uint16x8_t limit) {
    const auto above = [&](int i) {
      return vmovn_u16(vcgtq_u16(vreinterpretq_u16_u8(vld1q_u8(at + 16 * i)), limit));
    };
    return BitsOf(vcombine_u8(above(0), above(1)), vcombine_u8(above(2), above(3)));
  }
};

#endif

/// Rows too short for half a word, by the plain loop.
template <RowScan kLong, RowScan kShort>
bool ScanRow(const std::uint8_t* row, int width, int threshold, std::uint64_t* bright) {
  return width < kHalf ? kShort(row, width, threshold, bright) : kLong(row, width, threshold, bright);
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
  if (HasAvx2())
    return bytes ? ScanRow<ScanAvx2<Avx2x8>, ScanRowPlain8> : ScanRow<ScanAvx2<Avx2x16>, ScanRowPlain16>;
  return bytes ? ScanRow<Scan<Sse2x8>, ScanRowPlain8> : ScanRow<Scan<Sse2x16>, ScanRowPlain16>;
#elif defined(__aarch64__)
  return bytes ? ScanRow<Scan<Neon8>, ScanRowPlain8> : ScanRow<Scan<Neon16>, ScanRowPlain16>;
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
