// Eight floats at a time, in vectors of the compiler's own: lane by lane the same operations in the same
// order on every processor.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "firmware/detect/avx2.h"
#include "firmware/detect/spot_patch.h"

namespace adit::detect {

inline constexpr int kFloatLanes = SpotPatch::kLanes, kRowVectors = SpotPatch::kRowFloats / kFloatLanes;
using Floats = float __attribute__((vector_size(kFloatLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kFloatLanes * sizeof(float))));
using FloatsRow = std::array<Floats, kRowVectors>;

inline constexpr Floats kLaneIndex{0, 1, 2, 3, 4, 5, 6, 7};

/// x -> exp(x) to 3e-7 for x from -80 to 80, which a smaller x is taken for: 2^n times a polynomial
/// (Taylor's) of what is left of x / ln 2. Not the library's, whose last bit depends on the processor.
ADIT_INLINE void Exp(Floats& x) {
  constexpr float kLeast = -80, kLog2E = 1.44269504F, kLn2 = 0.69314718F;
  constexpr float kRound = 12582912.F;  // 1.5 * 2^23: adding it rounds to whole numbers
  const Floats bounded = x < kLeast ? Floats{} + kLeast : x;
  const Floats y = bounded * kLog2E, n = (y + kRound) - kRound, f = (y - n) * kLn2;
  const Floats rest =
      1.F + f * (1.F + f * (0.5F + f * (1 / 6.F + f * (1 / 24.F + f * (1 / 120.F + f * (1 / 720.F))))));
  const Ints scale = (__builtin_convertvector(n, Ints) + 127) << 23;  // 2^n
  Floats power;
  std::memcpy(&power, &scale, sizeof(power));
  x = rest * power;
}

ADIT_INLINE float SumLanes(const Floats& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

}  // namespace adit::detect
