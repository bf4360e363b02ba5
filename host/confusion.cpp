#include "host/confusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "firmware/identify/quadruple.h"

namespace adit::host {
namespace {

using LineImage = std::array<double, base::kLedCount>;

constexpr int kLeans = 2;      // to either side of across the view: the farthest lean images a bar shortest
constexpr int kGainSteps = 8;  // brackets for the depth gain
constexpr int kGoldenSteps = 12;  // narrow a bracket 300-fold
constexpr int kDistanceSteps = 60;

/// Places of the LEDs along the image line, px.
LineImage ImageOf(const base::Target& target, double distance_m, double tilt_rad, double focal_px) {
  LineImage image{};
  for (std::size_t i = 0; i < image.size(); ++i) {
    const double along_m = target.leds_m[i] - target.LengthM() / 2;
    image[i] = focal_px * along_m * std::cos(tilt_rad) / (distance_m + along_m * std::sin(tilt_rad));
  }
  return image;
}

/// Sum of squares left when `image` is fitted by offset + scale * shape.
double Misfit(const LineImage& image, const LineImage& shape) {
  double mean_i = 0, mean_s = 0;
  for (std::size_t i = 0; i < image.size(); ++i) mean_i += image[i] / 4, mean_s += shape[i] / 4;
  double ii = 0, is = 0, ss = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const double a = image[i] - mean_i, b = shape[i] - mean_s;
    ii += a * a, is += a * b, ss += b * b;
  }
  return is > 0 ? std::max(0.0, ii - is * is / ss) : ii;
}

/// A bar with LEDs at shares `u` of its length images them at u / (1 + k u), k the relative gain of depth.
double MisfitAtGain(const LineImage& image, const LineImage& shares, double gain) {
  LineImage shape{};
  for (std::size_t i = 0; i < shape.size(); ++i) shape[i] = shares[i] / (1 + gain * shares[i]);
  return Misfit(image, shape);
}

double LeastMisfit(const LineImage& image, const LineImage& shares, double gain_max) {
  double best = std::numeric_limits<double>::infinity(), best_gain = 0;
  for (int i = -kGainSteps; i <= kGainSteps; ++i) {
    const double gain = gain_max * i / kGainSteps;
    const double misfit = MisfitAtGain(image, shares, gain);
    if (misfit < best) best = misfit, best_gain = gain;
  }
  constexpr double kGolden = 0.6180339887498949;
  double low = std::max(-gain_max, best_gain - gain_max / kGainSteps);
  double high = std::min(gain_max, best_gain + gain_max / kGainSteps);
  for (int i = 0; i < kGoldenSteps; ++i) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    const double at_a = MisfitAtGain(image, shares, a), at_b = MisfitAtGain(image, shares, b);
    best = std::min({best, at_a, at_b});
    (at_a < at_b ? high : low) = at_a < at_b ? b : a;
  }
  return best;
}

LineImage SharesOf(const base::Target& target, bool is_reversed) {
  LineImage shares{};
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double share = target.leds_m[i] / target.LengthM();
    shares[is_reversed ? shares.size() - 1 - i : i] = is_reversed ? 1 - share : share;
  }
  return shares;
}

double OneWaySigmas(const base::Target& seen, const LineImage& shares, double distance_m,
                    const ViewConditions& conditions) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = -kLeans; i <= kLeans; ++i) {
    const double tilt_rad = conditions.tilt_max_rad * i / kLeans;
    const LineImage image = ImageOf(seen, distance_m, tilt_rad, conditions.focal_px);
    // Seen `length` long under a lean t, a bar gains tan(t) length / f of its distance in depth.
    const double gain_max =
        std::tan(conditions.tilt_max_rad) * (image.back() - image.front()) / conditions.focal_px;
    least = std::min(least, LeastMisfit(image, shares, gain_max));
  }
  return std::sqrt(least) / conditions.noise_px;
}

double MutualSigmas(const base::Target& a, const base::Target& b, double distance_m,
                    const ViewConditions& conditions) {
  return std::min(SeparationSigmas(a, b, distance_m, conditions),
                  SeparationSigmas(b, a, distance_m, conditions));
}

}  // namespace

double SeparationSigmas(const base::Target& seen, const base::Target& taken_for, double distance_m,
                        const ViewConditions& conditions) {
  return std::min(OneWaySigmas(seen, SharesOf(taken_for, false), distance_m, conditions),
                  OneWaySigmas(seen, SharesOf(taken_for, true), distance_m, conditions));
}

double DirectionSigmas(const base::Target& target, double distance_m, const ViewConditions& conditions) {
  return OneWaySigmas(target, SharesOf(target, true), distance_m, conditions);
}

double NeededSigmas(double noise_px) {
  const identify::IdentifierOptions options;
  constexpr double kNoiseSigmas = 4.5;
  return options.sigmas * std::hypot(noise_px, options.centroid_floor_px) / noise_px + kNoiseSigmas;
}

std::optional<double> DistinctUpToM(const base::Target& a, const base::Target& b, double nearest_m,
                                    double farthest_m, const ViewConditions& conditions) {
  const double needed = NeededSigmas(conditions.noise_px);
  std::optional<double> distinct_m;
  for (int i = 0; i <= kDistanceSteps; ++i) {
    const double distance_m = nearest_m * std::pow(farthest_m / nearest_m, double{1} * i / kDistanceSteps);
    if (MutualSigmas(a, b, distance_m, conditions) < needed) return distinct_m;
    distinct_m = distance_m;
  }
  return farthest_m;
}

}  // namespace adit::host
