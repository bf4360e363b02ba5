// What counts and normalised errors say with 95 %.
#pragma once

#include <cmath>
#include <cstddef>

namespace adit::host {

/// If a stated covariance is true, 95 % of the means of `freedom` squared normalised errors lie between these
/// (Wilson and Hilferty 1931).
struct NormalisedErrorLimits {
  double low, high;

  explicit NormalisedErrorLimits(double freedom) {
    const double part = 2 / (9 * freedom);
    low = std::pow(1 - part - 1.96 * std::sqrt(part), 3);
    high = std::pow(1 - part + 1.96 * std::sqrt(part), 3);
  }
};

/// The mean of a Poisson process that 95 % exclude after `events` of it: P(N <= events | mean) = 5 %.
inline double PoissonUpper95(std::size_t events) {
  const auto share = [events](double mean) {
    double term = std::exp(-mean), sum = term;
    for (std::size_t k = 1; k <= events; ++k) sum += term *= mean / static_cast<double>(k);
    return sum;
  };
  double low = 0, high = 10 + 3 * static_cast<double>(events);
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (share(middle) > 0.05 ? low : high) = middle;
  }
  return low;
}

}  // namespace adit::host
