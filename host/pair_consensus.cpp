#include "host/pair_consensus.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Three bars (nine equations) are the least; six keep the sample from being nearly degenerate and its noise
// low.
constexpr std::size_t kSampleBars = 6;
constexpr int kRefits = 4;

double BarErrorPx2(const Matrix3d& essential, const RayBar& bar, double focal_px) {
  double sum = 0;
  for (const RayPair& led : bar) sum += SampsonSquared(essential, led);
  return sum / static_cast<double>(bar.size()) * focal_px * focal_px;
}

std::optional<Matrix3d> FitBars(std::span<const RayBar> bars, std::span<const std::size_t> chosen) {
  std::vector<RayPair> points;
  points.reserve(chosen.size() * base::kLedCount);
  for (const std::size_t i : chosen) points.insert(points.end(), bars[i].begin(), bars[i].end());
  return EssentialFromPoints(points);
}

/// One hypothesis: what it is, which bars agree, and how badly all bars fit.
struct Hypothesis {
  Matrix3d essential = Matrix3d::Zero();
  std::vector<std::size_t> bars;
  double score_px2 = std::numeric_limits<double>::infinity();
};

Hypothesis Score(const Matrix3d& essential, std::span<const RayBar> bars, double focal_px, double gate_px) {
  Hypothesis h{essential, {}, 0};
  const double gate_px2 = gate_px * gate_px;
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double error_px2 = BarErrorPx2(essential, bars[i], focal_px);
    h.score_px2 += std::min(error_px2, gate_px2);
    if (error_px2 < gate_px2) h.bars.push_back(i);
  }
  return h;
}

void DrawSample(std::mt19937_64& random, std::size_t count, std::vector<std::size_t>& sample) {
  sample.clear();
  while (sample.size() < kSampleBars) {
    const std::size_t i = random() % count;
    if (std::find(sample.begin(), sample.end(), i) == sample.end()) sample.push_back(i);
  }
}

}  // namespace

bool LooksSimilar(const StereoBar& bar, double angle_max_rad) {
  const auto angles = [](const BarView& view) {
    const Vector2d along = (view.back().ideal_px - view.front().ideal_px).normalized();
    return Vector2d(std::acos(std::clamp(along.x(), -1.0, 1.0)), std::acos(std::clamp(along.y(), -1.0, 1.0)));
  };
  const Vector2d miss = (angles(bar.left) - angles(bar.right)).cwiseAbs();
  return miss.maxCoeff() <= angle_max_rad;  // NaN (LEDs in one place) compares false: not similar
}

std::optional<Consensus> FindConsensus(std::span<const RayBar> bars, double focal_px,
                                       const ConsensusOptions& options) {
  if (bars.size() < kSampleBars) return std::nullopt;
  std::mt19937_64 random(options.seed);
  std::vector<std::size_t> sample;
  Hypothesis best;
  for (int round = 0; round < options.rounds; ++round) {
    DrawSample(random, bars.size(), sample);
    auto essential = FitBars(bars, sample);
    if (!essential) continue;
    Hypothesis hypothesis = Score(*essential, bars, focal_px, options.gate_px);
    // Refitting costs more than scoring, so only for hypotheses that already lead.
    for (int refit = 0; refit < kRefits && hypothesis.score_px2 < best.score_px2; ++refit) {
      best = hypothesis;
      if (best.bars.size() < kSampleBars) break;
      essential = FitBars(bars, best.bars);
      if (!essential) break;
      hypothesis = Score(*essential, bars, focal_px, options.gate_px);
    }
  }
  if (best.bars.size() < kSampleBars) return std::nullopt;
  return Consensus{best.essential, best.bars};
}

}  // namespace adit::host
