#include "firmware/detect/row_scan.h"

#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "firmware/detect/avx2.h"

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace adit::detect {
namespace {

constexpr int kWord = 64;  // pixels

/// Appends words to a row's; a dark one is overwritten by the next. Counted without a branch: where lamps
/// begin and end no processor guesses.
class LitWords {
 public:
  ADIT_INLINE explicit LitWords(LitWord* to) : to_(to) {}
  ADIT_INLINE void Add(std::uint64_t bright, int first_px) {
    to_[count_] = {bright, static_cast<std::uint32_t>(first_px)};
    count_ += bright != 0 ? 1 : 0;
  }
  ADIT_INLINE std::size_t Count() const { return count_; }

 private:
  LitWord* to_;
  std::size_t count_ = 0;
};

template <typename Pixel>
std::size_t ScanPlain(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  LitWords words(lit);
  for (int x = 0; x < width; x += kWord) {
    std::uint64_t word = 0;
    for (int i = 0; i < kWord && x + i < width; ++i) {
      Pixel value = 0;
      std::memcpy(&value, row + static_cast<std::ptrdiff_t>(sizeof(Pixel)) * (x + i), sizeof(Pixel));
      word |= static_cast<std::uint64_t>(value > threshold) << i;
    }
    words.Add(word, x);
  }
  return words.Count();
}

// The scans below have one shape: whole words, then the word of the row's last 64 pixels, shifted; a row
// shorter than that is its first and its last 32 pixels. Each is made of what gives the bits of 32 pixels. Of
// a pixel and the least bright value the larger one is the pixel where it is bright.
constexpr int kHalf = kWord / 2;

template <typename Half>
std::size_t Scan(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  const auto least = Half::Least(threshold + 1);
  const auto half = [&](int x) {
    return Half::Bits(row + std::ptrdiff_t{sizeof(typename Half::Pixel)} * x, least);
  };
  const auto word = [&](int x) { return half(x) | half(x + kHalf) << kHalf; };
  LitWords words(lit);
  if (width < kWord) {
    words.Add(half(0) | half(width - kHalf) << (width - kHalf), 0);
    return words.Count();
  }
  int x = 0;
  for (; x + kWord <= width; x += kWord) words.Add(word(x), x);
  if (x < width) words.Add(word(width - kWord) >> (x + kWord - width), x);
  return words.Count();
}

#if defined(__x86_64__)

std::uint64_t BitsOf(__m128i bytes) { return static_cast<std::uint32_t>(_mm_movemask_epi8(bytes)); }

struct Sse2x8 {
  using Pixel = std::uint8_t;
  static __m128i Least(int dn) { return _mm_set1_epi8(static_cast<char>(dn)); }
  static std::uint64_t Bits(const std::uint8_t* at, __m128i least) {
    const auto bright = [&](int i) {
      const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at) + i);
      return BitsOf(_mm_cmpeq_epi8(_mm_max_epu8(pixels, least), pixels));
    };
    return bright(0) | bright(1) << 16;
  }
};

struct Sse2x16 {
  using Pixel = std::uint16_t;
  static __m128i Least(int dn) { return _mm_set1_epi16(static_cast<short>(dn)); }
  static std::uint64_t Bits(const std::uint8_t* at, __m128i least) {
    const auto bright = [&](int i) {
      const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(at) + i);
      return _mm_cmpeq_epi16(_mm_max_epu16(pixels, least), pixels);
    };
    return BitsOf(_mm_packs_epi16(bright(0), bright(1))) | BitsOf(_mm_packs_epi16(bright(2), bright(3)))
                                                               << 16;
  }
};

ADIT_AVX2 std::uint64_t BitsOf(__m256i bytes) {
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(bytes));
}

struct Avx2x8 {
  using Pixel = std::uint8_t;
  ADIT_AVX2 static __m256i Least(int dn) { return _mm256_set1_epi8(static_cast<char>(dn)); }
  ADIT_AVX2 static std::uint64_t Bits(const std::uint8_t* at, __m256i least) {
    const __m256i pixels = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
    return BitsOf(_mm256_cmpeq_epi8(_mm256_max_epu8(pixels, least), pixels));
  }
  ADIT_AVX2 static __m256i Larger(__m256i a, __m256i b) { return _mm256_max_epu8(a, b); }
};

struct Avx2x16 {
  using Pixel = std::uint16_t;
  ADIT_AVX2 static __m256i Least(int dn) { return _mm256_set1_epi16(static_cast<short>(dn)); }
  ADIT_AVX2 static std::uint64_t Bits(const std::uint8_t* at, __m256i least) {
    const __m256i p = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
    const __m256i q = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at) + 1);
    const __m256i a = _mm256_cmpeq_epi16(_mm256_max_epu16(p, least), p);
    const __m256i b = _mm256_cmpeq_epi16(_mm256_max_epu16(q, least), q);
    // Packing works within halves: 0 2 1 3 puts the quarters back in order.
    return BitsOf(_mm256_permute4x64_epi64(_mm256_packs_epi16(a, b), 0b11'01'10'00));
  }
  ADIT_AVX2 static __m256i Larger(__m256i a, __m256i b) { return _mm256_max_epu16(a, b); }
};

/// Whether all pixels of a block are dark: nothing is larger than one less than the least bright value.
template <typename Half, int kVectors>
ADIT_AVX2 bool AllDark(const std::uint8_t* at, __m256i brightest_dark) {
  const auto* const p = reinterpret_cast<const __m256i*>(at);
  __m256i most = _mm256_loadu_si256(p);
  for (int i = 1; i < kVectors; ++i) most = Half::Larger(most, _mm256_loadu_si256(p + i));
  const __m256i same = _mm256_cmpeq_epi8(Half::Larger(most, brightest_dark), brightest_dark);
  return _mm256_movemask_epi8(same) == -1;
}

/// Scan again, without lambdas: those would not be compiled for AVX2. Blocks that are dark are passed over.
template <typename Half>
ADIT_AVX2 std::size_t ScanAvx2(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  constexpr std::ptrdiff_t kHalfBytes = std::ptrdiff_t{sizeof(typename Half::Pixel)} * kHalf;
  const __m256i least = Half::Least(threshold + 1);
  const std::uint8_t* const last = row + std::ptrdiff_t{sizeof(typename Half::Pixel)} * width - kHalfBytes;
  LitWords words(lit);
  if (width < kWord) {
    words.Add(Half::Bits(row, least) | Half::Bits(last, least) << (width - kHalf), 0);
    return words.Count();
  }
  const __m256i brightest_dark = Half::Least(threshold);
  constexpr int kBlockVectors = 8;
  constexpr int kBlock = kBlockVectors * 32 / static_cast<int>(sizeof(typename Half::Pixel));
  int x = 0;
  while (x + kBlock <= width) {
    const int end = x + kBlock;
    if (AllDark<Half, kBlockVectors>(row, brightest_dark)) {
      x = end, row += 32 * kBlockVectors;
      continue;
    }
    for (; x < end; x += kWord, row += 2 * kHalfBytes)
      words.Add(Half::Bits(row, least) | Half::Bits(row + kHalfBytes, least) << kHalf, x);
  }
  for (; x + kWord <= width; x += kWord, row += 2 * kHalfBytes)
    words.Add(Half::Bits(row, least) | Half::Bits(row + kHalfBytes, least) << kHalf, x);
  if (x < width) {
    const std::uint64_t word = Half::Bits(last - kHalfBytes, least) | Half::Bits(last, least) << kHalf;
    words.Add(word >> (x + kWord - width), x);
  }
  return words.Count();
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
  using Pixel = std::uint8_t;
  static uint8x16_t Least(int dn) { return vdupq_n_u8(static_cast<std::uint8_t>(dn)); }
  static std::uint64_t Bits(const std::uint8_t* at, uint8x16_t least) {
    return BitsOf(vcgeq_u8(vld1q_u8(at), least), vcgeq_u8(vld1q_u8(at + 16), least));
  }
};

struct Neon16 {
  using Pixel = std::uint16_t;
  static uint16x8_t Least(int dn) { return vdupq_n_u16(static_cast<std::uint16_t>(dn)); }
  static std::uint64_t Bits(const std::uint8_t* at, uint16x8_t least) {
    const auto bright = [&](int i) {
      return vmovn_u16(vcgeq_u16(vreinterpretq_u16_u8(vld1q_u8(at + 16 * i)), least));
    };
    return BitsOf(vcombine_u8(bright(0), bright(1)), vcombine_u8(bright(2), bright(3)));
  }
};

#endif

constexpr std::size_t kVectorBytes = 32;
using BytePixels = std::uint8_t __attribute__((vector_size(kVectorBytes)));
using WidePixels = std::uint16_t __attribute__((vector_size(kVectorBytes)));
using VectorWords = std::uint64_t __attribute__((vector_size(kVectorBytes)));

template <typename Pixels>
ADIT_INLINE std::size_t DarkBytes(const Bands& at, std::size_t count, int threshold) {
  using Pixel = std::remove_cvref_t<decltype(Pixels{}[0])>;
  const Pixels brightest_dark = Pixels{} + static_cast<Pixel>(threshold);
  constexpr std::size_t kVectors = 8;  // of each place in turn
  std::size_t done = 0;
  for (; done + kVectors * kVectorBytes <= count; done += kVectors * kVectorBytes) {
    Pixels changed{};
    for (const std::uint8_t* const place : at) {
      Pixels most = brightest_dark;
      for (std::size_t i = 0; i < kVectors; ++i) {
        Pixels pixels;
        std::memcpy(&pixels, place + done + i * kVectorBytes, kVectorBytes);
        most = pixels > most ? pixels : most;
      }
      changed |= most ^ brightest_dark;
    }
    VectorWords any;
    std::memcpy(&any, &changed, kVectorBytes);
    if ((any[0] | any[1] | any[2] | any[3]) != 0) break;
  }
  return done;
}

template <typename Pixels>
std::size_t DarkBytesBaseline(const Bands& at, std::size_t count, int threshold) {
  return DarkBytes<Pixels>(at, count, threshold);
}
template <typename Pixels>
ADIT_AVX2 std::size_t DarkBytesAvx2(const Bands& at, std::size_t count, int threshold) {
  return DarkBytes<Pixels>(at, count, threshold);
}

/// Rows too short for half a word by the plain loop, and nothing at all where no value is bright.
template <typename Half, RowScan kScan, RowScan kPlain>
std::size_t ScanRow(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  if (threshold >= std::numeric_limits<typename Half::Pixel>::max()) return 0;
  return (width < kHalf ? kPlain : kScan)(row, width, threshold, lit);
}

}  // namespace

std::size_t ScanRowPlain8(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  return ScanPlain<std::uint8_t>(row, width, threshold, lit);
}

std::size_t ScanRowPlain16(const std::uint8_t* row, int width, int threshold, LitWord* lit) {
  return ScanPlain<std::uint16_t>(row, width, threshold, lit);
}

RowScan FastestRowScan(int bytes_per_pixel) {
  const bool bytes = bytes_per_pixel == 1;
#if defined(__x86_64__)
  if (HasAvx2()) {
    return bytes ? ScanRow<Avx2x8, ScanAvx2<Avx2x8>, ScanRowPlain8>
                 : ScanRow<Avx2x16, ScanAvx2<Avx2x16>, ScanRowPlain16>;
  }
  return bytes ? ScanRow<Sse2x8, Scan<Sse2x8>, ScanRowPlain8>
               : ScanRow<Sse2x16, Scan<Sse2x16>, ScanRowPlain16>;
#elif defined(__aarch64__)
  return bytes ? ScanRow<Neon8, Scan<Neon8>, ScanRowPlain8> : ScanRow<Neon16, Scan<Neon16>, ScanRowPlain16>;
#else
  return bytes ? ScanRowPlain8 : ScanRowPlain16;
#endif
}

DarkScan FastestDarkScan(int bytes_per_pixel) {
  if (bytes_per_pixel == 1) return HasAvx2() ? DarkBytesAvx2<BytePixels> : DarkBytesBaseline<BytePixels>;
  return HasAvx2() ? DarkBytesAvx2<WidePixels> : DarkBytesBaseline<WidePixels>;
}

std::size_t RowEdges(std::span<const LitWord> lit, std::uint16_t* edges) {
  const std::uint16_t* const first = edges;
  std::uint64_t before = 0;  // the pixel left of the word
  std::uint32_t end_px = 0;  // of the word before
  const auto add = [&edges](std::uint32_t x_px) { *edges++ = static_cast<std::uint16_t>(x_px); };
  for (const LitWord& word : lit) {
    if (word.first_px != end_px && before != 0) {
      add(end_px);
      before = 0;
    }
    std::uint64_t changes = word.bright ^ (word.bright << 1 | before);
    before = word.bright >> (kWord - 1);
    end_px = word.first_px + kWord;
    // Mostly there are two: written without asking, as a branch that is guessed wrong costs more.
    std::uint16_t* const next = edges + std::popcount(changes);
    for (int i = 0; i < 2; ++i, changes &= changes - 1)
      add(word.first_px + static_cast<std::uint32_t>(std::countr_zero(changes)));
    for (; changes != 0; changes &= changes - 1)
      add(word.first_px + static_cast<std::uint32_t>(std::countr_zero(changes)));
    edges = next;
  }
  if (before != 0) add(end_px);
  return static_cast<std::size_t>(edges - first);
}

}  // namespace adit::detect
