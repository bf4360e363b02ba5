#include "firmware/stereo/point_set.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

namespace {

/// Least and largest of some ratios.
struct Range {
  float least = HUGE_VALF, most = 0;

  void Take(float ratio) { least = std::min(least, ratio), most = std::max(most, ratio); }
  bool IsWithin(float factor) const { return most <= factor * least; }
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

bool SameBrightness(const LedFlux& known, const LedFlux& seen, float within) {
  Range of_known;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto ratios = Ratios(known[side], seen[side]);
    Range in_image;
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      if (!(ratios[i] > 0)) continue;
      in_image.Take(ratios[i]);
      if (known[side][i] > 0) of_known.Take(ratios[i]);
    }
    if (!in_image.IsWithin(within)) return false;
  }
  return of_known.IsWithin(within);
}

bool IsUncovered(const LedFlux& known, const LedFlux& seen, std::size_t side, std::size_t led) {
  const auto ratios = Ratios(known[side], seen[side]);
  float others = 0, count = 0;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    if (i != led && ratios[i] > 0) others += ratios[i], ++count;
  }
  const float ratio = ratios[led] * count / others;
  return ratio <= kSameLed && ratio * kSameLed >= 1;
}

}  // namespace adit::stereo
