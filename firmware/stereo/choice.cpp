#include "firmware/stereo/choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector3d;

namespace {

bool SamePlace(const Solution& a, const Solution& b, const LocatorOptions& options) {
  const double within_m = SameWithinM(a, b, options);
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!((a.points.leds_b_m[i] - b.points.leds_b_m[i]).norm() <= within_m)) return false;
  }
  return (a.points.epicenter_b_m - b.points.epicenter_b_m).norm() <= within_m;
}

/// Lets the covariance of `points` cover another place that as many LEDs speak for: one of them has merged
/// with a lamp, and which one is not known.
void Cover(const TargetPoints& other, TargetPoints& points) {
  constexpr double kDiffers = 9;  // squared, in standard deviations: less is noise, and covered already
  const Vector3d apart_m = other.epicenter_b_m - points.epicenter_b_m;
  if (!(apart_m.dot(points.epicenter_covariance_m2.ldlt().solve(apart_m)) > kDiffers)) return;
  const Vector3d turn = other.direction_b - points.direction_b;
  points.epicenter_covariance_m2 += apart_m * apart_m.transpose();
  points.direction_covariance += turn * turn.transpose();
  points.epicenter_direction_covariance_m += apart_m * turn.transpose();
}

}  // namespace

bool ShareABlob(const Solution& a, const Solution& b) {
  const auto shares = [](const BlobIndices& x, const BlobIndices& y) {
    return std::any_of(x.begin(), x.end(), [&y](std::uint16_t i) {
      return i != kNoBlob && std::find(y.begin(), y.end(), i) != y.end();
    });
  };
  return shares(a.points.blobs[0], b.points.blobs[0]) || shares(a.points.blobs[1], b.points.blobs[1]);
}

void Add(const LocatorOptions& options, const Solution& solution, Finding& finding) {
  for (Solution& known : finding.solutions) {
    if (!SamePlace(known, solution, options)) continue;
    const bool is_better = solution.cost < known.cost;
    const Solution other = is_better ? known : solution;
    if (is_better) known = solution;
    if (other.seen >= known.seen && !known.complete) Cover(other.points, known.points);
    return;
  }
  if (!finding.solutions.push_back(solution)) finding.crowded = true;
}

bool Explains(const Solution& solution, const BarBlobs& blobs) {
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < kLedCount; ++i) {
      if (blobs[side][i] != kNoBlob && solution.points.blobs[side][i] != blobs[side][i]) return false;
    }
  }
  return true;
}

const Solution* Choose(const LocatorOptions& options, const Solution* expected, Mirrors& mirrors,
                       Finding& finding) {
  if (finding.solutions.empty() && !finding.crowded) return nullptr;
  finding.reason = LossReason::kAmbiguous;
  if (finding.crowded) return nullptr;
  auto& solutions = finding.solutions;
  std::sort(solutions.begin(), solutions.end(),
            [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  const auto is_reflection = [&](const Solution& s) {
    if (mirrors.IsBehind(s) || (expected != nullptr && mirrors.IsImage(*expected, s))) return true;
    return std::any_of(solutions.begin(), solutions.end(), [&](const Solution& other) {
      const bool is_image = mirrors.IsImage(other, s);
      if (is_image) mirrors.Remember(other, s);
      return is_image;
    });
  };
  const Solution* best = nullptr;
  for (const Solution& s : solutions) {
    if (is_reflection(s)) continue;
    if (best == nullptr) {
      best = &s;
    } else if (s.cost < best->cost + options.chi_square_margin) {
      return nullptr;
    }
  }
  if (best != nullptr) finding.reason = LossReason::kNone;
  return best;
}

void ResolveShared(const LocatorOptions& options, std::vector<const Solution*>& chosen,
                   std::vector<Finding>& findings) {
  std::array<bool, identify::kMaxTargets> falls{}, is_another{};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    for (std::size_t j = 0; chosen[i] != nullptr && j < chosen.size(); ++j) {
      for (const Solution& other : findings[j].solutions) {
        if (j == i || !ShareABlob(*chosen[i], other)) continue;
        const double difference = chosen[i]->cost - other.cost;
        if (difference > -options.chi_square_margin) falls[i] = true;
        if (difference >= options.chi_square_margin) is_another[i] = true;
      }
    }
  }
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (!falls[i]) continue;
    chosen[i] = nullptr;
    findings[i].reason = is_another[i] ? LossReason::kNotSeen : LossReason::kAmbiguous;
  }
}

}  // namespace adit::stereo
