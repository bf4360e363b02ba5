#include "host/training.h"

#include <algorithm>
#include <cmath>

#include "firmware/identify/p2_invariant.h"

namespace adit::host {
namespace {

using identify::Model;

constexpr double kP2Min = 2.0, kP2Max = 2.8;  // of the invariant itself
constexpr double kSigmas = 4.5;
// The same probability for the rms of four residuals about a line: chi-square of 2 degrees beyond 23.7.
constexpr double kCollinearitySigmas = 2.43;
constexpr int kDistances = 40, kTilts = 25, kNoiseSteps = 20;
constexpr double kLengthSlack = 0.1;  // bars off the centre: 1/cos of up to 15 degrees, twice
constexpr double kGeometrySlack = 0.5, kMeasuredSlack = 0.2, kCollinearitySlack = 1.25;
constexpr double kTail = 0.005;  // of the samples, at either end

/// A range that grows.
struct Span {
  double min = INFINITY, max = -INFINITY;
  void Include(double value) { min = std::min(min, value), max = std::max(max, value); }
  double Width() const { return max - min; }
};

/// Places of the LEDs along the bar's image, px, for a bar whose middle is `distance_m` away and that leans
/// by `tilt_rad`.
identify::LinePlaces ImagePlaces(const base::Target& target, double distance_m, double tilt_rad,
                                 double focal_px) {
  identify::LinePlaces places{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double along_m = target.leds_m[i] - target.LengthM() / 2;
    places[i] = focal_px * along_m * std::cos(tilt_rad) / (distance_m + along_m * std::sin(tilt_rad));
  }
  return places;
}

/// p2 over the cross ratios that noise can make of this view.
void IncludeP2(const identify::LinePlaces& places_px, double noise_px, Span& p2) {
  const double ratio = identify::CrossRatio(places_px);
  double slopes2 = 0;
  for (const double slope : identify::CrossRatioSlopes(places_px)) slopes2 += slope * slope;
  const double reach = kSigmas * noise_px * std::sqrt(slopes2);
  for (int step = -kNoiseSteps; step <= kNoiseSteps; ++step) {
    const double noisy = ratio + reach * step / kNoiseSteps;
    if (noisy > 0 && noisy < 1) p2.Include(identify::P2(noisy));
  }
}

double Quantile(std::vector<double> values, double share) {
  const auto last = static_cast<double>(values.size() - 1);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::lround(share * last));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// The middle of the samples, widened by `slack` times its width.
Span MeasuredSpan(const std::vector<TrainingSample>& samples, double TrainingSample::*figure, double slack) {
  std::vector<double> values;
  for (const TrainingSample& sample : samples) values.push_back(sample.*figure);
  Span span;
  span.Include(Quantile(values, kTail));
  span.Include(Quantile(values, 1 - kTail));
  const double margin = slack * span.Width();
  return {span.min - margin, span.max + margin};
}

void ClampP2(Model& model) {
  model.p2_min = std::max(kP2Min, model.p2_min);
  model.p2_max = std::min(kP2Max, model.p2_max);
}

}  // namespace

Model NoiseRanges(const base::Target& target, const TrainingOptions& options) {
  Span p2, length_px;
  for (int d = 0; d <= kDistances; ++d) {
    const double distance_m =
        options.nearest_m * std::pow(options.farthest_m / options.nearest_m, double{1} * d / kDistances);
    for (int t = -kTilts; t <= kTilts; ++t) {
      const auto places_px =
          ImagePlaces(target, distance_m, options.tilt_max_rad * t / kTilts, options.focal_px);
      IncludeP2(places_px, options.noise_px, p2);
      length_px.Include(places_px.back() - places_px.front());
    }
  }
  Model model;
  model.target = target;
  model.p2_min = p2.min, model.p2_max = p2.max;
  model.collinearity_max = std::min(1.0, kCollinearitySigmas * options.noise_px / length_px.min);
  model.length_min_px = length_px.min * (1 - kLengthSlack);
  model.length_max_px = length_px.max * (1 + kLengthSlack);
  ClampP2(model);
  return model;
}

Model GeometryModel(const base::Target& target, const TrainingOptions& options) {
  Model model = NoiseRanges(target, options);
  const double margin = kGeometrySlack * (model.p2_max - model.p2_min);
  model.p2_min -= margin;
  model.p2_max += margin;
  model.collinearity_max = std::min(1.0, model.collinearity_max * (1 + 2 * kGeometrySlack));
  ClampP2(model);
  return model;
}

TrainingSample SampleOf(const identify::Sighting& sighting) {
  return {static_cast<double>(sighting.p2),
          static_cast<double>(sighting.collinearity_px / sighting.length_px),
          static_cast<double>(sighting.length_px)};
}

Model RefinedModel(const Model& noise, const TrainingTally& tally) {
  Model model = noise;
  if (tally.samples.empty()) return model;
  const Span p2 = MeasuredSpan(tally.samples, &TrainingSample::p2, kMeasuredSlack);
  const Span line = MeasuredSpan(tally.samples, &TrainingSample::collinearity, 0);
  const Span length_px = MeasuredSpan(tally.samples, &TrainingSample::length_px, 0);
  model.p2_min = std::min(model.p2_min, p2.min);
  model.p2_max = std::max(model.p2_max, p2.max);
  model.collinearity_max = std::min(1.0, std::max(model.collinearity_max, kCollinearitySlack * line.max));
  model.length_min_px = std::min(model.length_min_px, length_px.min * (1 - kLengthSlack));
  model.length_max_px = std::max(model.length_max_px, length_px.max * (1 + kLengthSlack));
  ClampP2(model);
  return model;
}

}  // namespace adit::host
