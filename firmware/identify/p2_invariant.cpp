#include "firmware/identify/p2_invariant.h"

namespace adit::identify {
namespace {

// Numerator and denominator of J, highest power first.
constexpr std::array<double, 7> kNumerator{2, -6, 9, -8, 9, -6, 2};
constexpr std::array<double, 7> kDenominator{1, -3, 3, -1, 3, -3, 1};

struct ValueAndSlope {
  double value, slope;
};

ValueAndSlope Horner(const std::array<double, 7>& coefficients, double x) {
  ValueAndSlope result{0, 0};
  for (const double coefficient : coefficients) {
    result.slope = result.slope * x + result.value;
    result.value = result.value * x + coefficient;
  }
  return result;
}

}  // namespace

double CrossRatio(const LinePlaces& places) {
  const auto [a, b, c, d] = places;
  return (b - a) * (d - c) / ((d - b) * (c - a));
}

LinePlaces CrossRatioSlopes(const LinePlaces& places) {
  const auto [a, b, c, d] = places;
  const double ratio = CrossRatio(places);
  // d ln(lambda): each factor contributes the inverse of its length.
  return {ratio * (1 / (c - a) - 1 / (b - a)), ratio * (1 / (b - a) + 1 / (d - b)),
          ratio * (-1 / (d - c) - 1 / (c - a)), ratio * (1 / (d - c) - 1 / (d - b))};
}

double P2(double cross_ratio) {
  return Horner(kNumerator, cross_ratio).value / Horner(kDenominator, cross_ratio).value;
}

double P2Slope(double cross_ratio) {
  const ValueAndSlope n = Horner(kNumerator, cross_ratio), d = Horner(kDenominator, cross_ratio);
  return (n.slope * d.value - n.value * d.slope) / (d.value * d.value);
}

}  // namespace adit::identify
