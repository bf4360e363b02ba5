#include "firmware/stereo/point_set.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

namespace {

constexpr float kWithin = 1.25F;  // a lamp half as bright as the LED that it merges with makes it 1.5

/// Least and largest of some ratios.
struct Range {
  float least = HUGE_VALF, most = 0;

  void Take(float ratio) { least = std::min(least, ratio), most = std::max(most, ratio); }
  bool IsNarrow() const { return most <= kWithin * least; }
};

/// How bright the LEDs of an image are beside what is known of them; those that are not seen: 0.
std::array<float, base::kLedCount> Ratios(const std::array<float, base::kLedCount>& known,
                                          const std::array<float, base::kLedCount>& seen) {
  float sum = 0, count = 0;
  for (const float flux : known) {
    if (flux > 0) sum += flux, ++count;
  }
  const float typical = count > 0 ? sum / count : 1;
  std::array<float, base::kLedCount> ratios{};
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    if (seen[i] > 0) ratios[i] = seen[i] / (known[i] > 0 ? known[i] : typical);
  }
  return ratios;
}

}  // namespace

bool SameBrightness(const LedFlux& known, const LedFlux& seen) {
  Range of_known;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto ratios = Ratios(known[side], seen[side]);
    Range in_image;
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      if (!(ratios[i] > 0)) continue;
      in_image.Take(ratios[i]);
      if (known[side][i] > 0) of_known.Take(ratios[i]);
    }
    if (!in_image.IsNarrow()) return false;
  }
  return of_known.IsNarrow();
}

bool IsUncovered(const LedFlux& known, const LedFlux& seen, std::size_t side, std::size_t led) {
  constexpr float kWithinTenth = 1.1F;  // noise is a hundredth; a leaning bar's ends differ by some more
  const auto ratios = Ratios(known[side], seen[side]);
  float others = 0, count = 0;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    if (i != led && ratios[i] > 0) others += ratios[i], ++count;
  }
  const float ratio = ratios[led] * count / others;
  return ratio <= kWithinTenth && ratio * kWithinTenth >= 1;
}

}  // namespace adit::stereo
