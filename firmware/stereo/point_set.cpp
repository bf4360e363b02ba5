#include "firmware/stereo/point_set.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

bool SameBrightness(const LedFlux& known, const LedFlux& seen) {
  constexpr float kWithin = 1.25F;  // a lamp half as bright as the LED that it merges with makes it 1.5
  float least = HUGE_VALF, most = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      if (!(known[side][i] > 0) || !(seen[side][i] > 0)) continue;
      const float ratio = seen[side][i] / known[side][i];
      least = std::min(least, ratio), most = std::max(most, ratio);
    }
  }
  return most <= kWithin * least;
}

}  // namespace adit::stereo
