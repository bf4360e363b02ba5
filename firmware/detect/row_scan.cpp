#include "firmware/detect/row_scan.h"

#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace adit::detect {
namespace {

/// Collects runs from pixels that come in ascending order; a run may go on over a block's end.
class RunWriter {
 public:
  RunWriter(Run* out, std::size_t room) : out_(out), room_(room) {}

  void Start(int x) { begin_ = x; }
  void End(int x) {
    if (count_ < room_) out_[count_] = {static_cast<std::uint16_t>(begin_), static_cast<std::uint16_t>(x), 0};
    ++count_;
    begin_ = -1;
  }
  bool Open() const { return begin_ >= 0; }

  /// 64 pixels from `x` on, bit i set where pixel x + i is bright.
  void Take(std::uint64_t mask, int x) {
    if (Open()) {
      const int ones = std::countr_one(mask);
      if (ones == 64) return;
      End(x + ones);
      mask &= ~0ULL << ones;
    }
    while (mask != 0) {
      const int first = std::countr_zero(mask);
      Start(x + first);
      const int ones = std::countr_one(mask >> first);
      if (first + ones == 64) return;
      End(x + first + ones);
      mask &= ~0ULL << (first + ones);
    }
  }
  std::size_t Finish(int width) {
    if (Open()) End(width);
    return count_;
  }

 private:
  Run* out_;
  std::size_t room_, count_ = 0;
  int begin_ = -1;
};

/// The pixels from x on, fewer than 64 of them.
std::uint64_t TailMask(const std::uint8_t* row, int x, int width, int threshold) {
  std::uint64_t mask = 0;
  for (int i = 0; x + i < width; ++i) mask |= static_cast<std::uint64_t>(row[x + i] > threshold) << i;
  return mask;
}

#if defined(__x86_64__)

std::size_t ScanRowSse2(const std::uint8_t* row, int width, int threshold, Run* out, std::size_t room) {
  RunWriter runs(out, room);
  const __m128i limit = _mm_set1_epi8(static_cast<char>(threshold));
  int x = 0;
  for (; x + 64 <= width; x += 64) {
    const auto* const p = reinterpret_cast<const __m128i*>(row + x);
    const __m128i a = _mm_loadu_si128(p), b = _mm_loadu_si128(p + 1), c = _mm_loadu_si128(p + 2),
                  d = _mm_loadu_si128(p + 3);
    // Saturated subtraction leaves 0 where a pixel is not brighter: most blocks are dark and end here.
    const __m128i zero = _mm_setzero_si128();
    const __m128i most = _mm_max_epu8(_mm_max_epu8(a, b), _mm_max_epu8(c, d));
    const bool dark = _mm_movemask_epi8(_mm_cmpeq_epi8(_mm_subs_epu8(most, limit), zero)) == 0xFFFF;
    if (dark && !runs.Open()) continue;
    const auto bright = [&](__m128i v) {
      return static_cast<std::uint64_t>(~_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_subs_epu8(v, limit), zero)) &
                                        0xFFFF);
    };
    runs.Take(bright(a) | bright(b) << 16 | bright(c) << 32 | bright(d) << 48, x);
  }
  runs.Take(TailMask(row, x, width, threshold), x);
  return runs.Finish(width);
}

__attribute__((target("avx2"))) std::uint64_t BrightAvx2(__m256i v, __m256i limit) {
  const __m256i dark = _mm256_cmpeq_epi8(_mm256_subs_epu8(v, limit), _mm256_setzero_si256());
  return static_cast<std::uint32_t>(~_mm256_movemask_epi8(dark));
}

__attribute__((target("avx2"))) std::size_t ScanRowAvx2(const std::uint8_t* row, int width, int threshold,
                                                        Run* out, std::size_t room) {
  RunWriter runs(out, room);
  const __m256i limit = _mm256_set1_epi8(static_cast<char>(threshold));
  int x = 0;
  for (; x + 64 <= width; x += 64) {
    const auto* const p = reinterpret_cast<const __m256i*>(row + x);
    const __m256i a = _mm256_loadu_si256(p), b = _mm256_loadu_si256(p + 1);
    const __m256i above = _mm256_subs_epu8(_mm256_max_epu8(a, b), limit);
    if (_mm256_testz_si256(above, above) != 0 && !runs.Open()) continue;
    runs.Take(BrightAvx2(a, limit) | BrightAvx2(b, limit) << 32, x);
  }
  runs.Take(TailMask(row, x, width, threshold), x);
  return runs.Finish(width);
}

#endif

}  // namespace

std::size_t ScanRowPlain(const std::uint8_t* row, int width, int threshold, Run* out, std::size_t room) {
  RunWriter runs(out, room);
  for (int x = 0; x < width; ++x) {
    const bool bright = row[x] > threshold;
    if (bright && !runs.Open()) runs.Start(x);
    if (!bright && runs.Open()) runs.End(x);
  }
  return runs.Finish(width);
}

std::size_t ScanRowPlain16(const std::uint8_t* row, int width, int threshold, Run* out, std::size_t room) {
  RunWriter runs(out, room);
  for (int x = 0; x < width; ++x) {
    std::uint16_t value = 0;
    std::memcpy(&value, row + 2 * x, sizeof(value));
    const bool bright = value > threshold;
    if (bright && !runs.Open()) runs.Start(x);
    if (!bright && runs.Open()) runs.End(x);
  }
  return runs.Finish(width);
}

RowScan FastestRowScan() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return ScanRowAvx2;
  return ScanRowSse2;
#else
  return ScanRowPlain;
#endif
}

}  // namespace adit::detect
