// Pairs of centroids, some of them perhaps hidden -> a located target, validated.
#pragma once

#include <array>
#include <optional>

#include "firmware/base/target.h"
#include "firmware/stereo/bar_fit.h"
#include "firmware/stereo/locator_options.h"
#include "firmware/stereo/point_set.h"
#include "firmware/stereo/triangulate.h"

namespace adit::stereo {

/// One place that passes for a target.
struct Solution {
  TargetPoints points;
  BarFit fit;
  double chi_square = 0;
  double cost = 0;       ///< chi-square and what is hidden: by this places are compared
  double flux_dn = 0;    ///< mean of the left blobs seen
  int seen = 0;          ///< centroids
  bool complete = true;  ///< all four LEDs are seen in both images
};

/// Whether two points can be `expected_m` apart: within `options.sigmas` of the propagated covariance plus
/// the scale allowance.
bool DistanceFits(const LocatedPoint& a, const LocatedPoint& b, double expected_m,
                  const LocatorOptions& options);

/// The chi-square that a normal variable's `sigmas` correspond to (Wilson and Hilferty 1931; within 2 %).
double ChiSquareLimit(int degrees_of_freedom, double sigmas);

/// Solves and validates.
class Solver {
 public:
  Solver(const optics::Rig& rig, const LocatorOptions& options) : views_(MakeViews(rig)), options_(options) {}

  /// Triangulates each LED that is seen in both images, validates the distances between neighbours among them
  /// and from the first to the last against the target's (seed 4.3.5), fits the rigid bar to all that is seen
  /// and judges its residuals. The LEDs that are not seen in both images are rebuilt from the fit. Everything
  /// but `target`, the blobs and the flux is filled. On refusal `reason` says why. Declines fewer than two
  /// LEDs seen in both.
  std::optional<Solution> Solve(const base::Target& target, const BarObservations& observations,
                                LossReason& reason) const;

 private:
  bool DistancesFit(const base::Target& target, const BarObservations& observations,
                    const std::array<LocatedPoint, base::kLedCount>& points) const;
  void Fill(const base::Target& target, const BarObservations& observations,
            const std::array<LocatedPoint, base::kLedCount>& points, Solution& out) const;

  Views views_;
  LocatorOptions options_;
};

}  // namespace adit::stereo
