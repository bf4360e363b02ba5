#include "tests/bench/read_bound.h"

#include <algorithm>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace adit::bench {
namespace {

std::uint8_t ReadPlain(const std::uint8_t* pixels, std::size_t count) {
  std::uint8_t most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, pixels[i]);
  return most;
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) std::uint8_t ReadAvx2(const std::uint8_t* pixels, std::size_t count) {
  constexpr std::size_t kStep = 128;
  __m256i most[4] = {};
  std::size_t i = 0;
  for (; i + kStep <= count; i += kStep) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const auto* const at = reinterpret_cast<const __m256i*>(pixels + i + 32 * lane);
      most[lane] = _mm256_max_epu8(most[lane], _mm256_loadu_si256(at));
    }
  }
  alignas(32) std::uint8_t bytes[32];
  _mm256_store_si256(reinterpret_cast<__m256i*>(bytes),
                     _mm256_max_epu8(_mm256_max_epu8(most[0], most[1]), _mm256_max_epu8(most[2], most[3])));
  return std::max(ReadPlain(bytes, sizeof bytes), ReadPlain(pixels + i, count - i));
}
#endif

}  // namespace

std::uint8_t ReadAll(std::span<const std::uint8_t> pixels) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return ReadAvx2(pixels.data(), pixels.size());
#endif
  return ReadPlain(pixels.data(), pixels.size());
}

}  // namespace adit::bench
