// Four pairs of centroids -> a located target, validated.
#pragma once

#include <array>
#include <optional>

#include "firmware/base/target.h"
#include "firmware/stereo/bar_fit.h"
#include "firmware/stereo/locator_options.h"
#include "firmware/stereo/point_set.h"
#include "firmware/stereo/triangulate.h"

namespace adit::stereo {

using LedPoints = std::array<LocatedPoint, base::kLedCount>;

/// One place that passes for a target.
struct Solution {
  TargetPoints points;
  double chi_square = 0;
  double flux_dn = 0;  ///< of the four left blobs
};

/// Whether two points can be `expected_m` apart: within `options.sigmas` of the propagated covariance plus
/// the scale allowance.
bool DistanceFits(const LocatedPoint& a, const LocatedPoint& b, double expected_m,
                  const LocatorOptions& options);

/// Solves and validates.
class Solver {
 public:
  Solver(const optics::Rig& rig, const LocatorOptions& options) : views_(MakeViews(rig)), options_(options) {}

  /// Triangulates each LED, validates the distances 1-2, 2-3, 3-4 and 1-4 against the target's (seed 4.3.5),
  /// fits the rigid bar and judges its residuals. Everything but `target`, the blobs and the flux is filled.
  /// On refusal `reason` says why.
  std::optional<Solution> Solve(const base::Target& target, const BarObservations& observations,
                                LossReason& reason) const;

 private:
  bool DistancesFit(const base::Target& target, const LedPoints& points) const;

  Views views_;
  LocatorOptions options_;
};

}  // namespace adit::stereo
