#include "firmware/stereo/solution.h"

#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector3d;

namespace {

using LedPoints = std::array<LocatedPoint, kLedCount>;

double DistanceSigmaM(const LocatedPoint& a, const LocatedPoint& b) {
  const Vector3d along = (b.point_b_m - a.point_b_m).normalized();
  return std::sqrt(along.dot((a.covariance_m2 + b.covariance_m2) * along));
}

}  // namespace

bool DistanceFits(const LocatedPoint& a, const LocatedPoint& b, double expected_m,
                  const LocatorOptions& options) {
  const double distance_m = (b.point_b_m - a.point_b_m).norm();
  // Written so that NaN (two points at one place) does not fit.
  return std::abs(distance_m - expected_m) <=
         options.scale * expected_m + options.sigmas * DistanceSigmaM(a, b);
}

double ChiSquareLimit(int degrees_of_freedom, double sigmas) {
  const double spread = 2.0 / (9.0 * degrees_of_freedom);
  const double root = 1 - spread + sigmas * std::sqrt(spread);
  return degrees_of_freedom * root * root * root;
}

bool Solver::DistancesFit(const base::Target& target, const BarObservations& observations,
                          const LedPoints& points) const {
  const auto fits = [&](std::size_t i, std::size_t j) {
    return DistanceFits(points[i], points[j], target.leds_m[j] - target.leds_m[i], options_);
  };
  std::size_t first = kLedCount, last = kLedCount;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!SeenInBoth(observations[i])) continue;
    if (first == kLedCount) first = i;
    if (last < i && !fits(last, i)) return false;
    last = i;
  }
  return first < last && last < kLedCount && fits(first, last);
}

void Solver::Fill(const base::Target& target, const BarObservations& observations, const LedPoints& points,
                  Solution& out) const {
  TargetPoints& p = out.points;
  std::array<LocatedPoint, kLedCount> all = points;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!SeenInBoth(observations[i])) {
      all[i] = {out.fit.PointM(target, target.leds_m[i]),
                out.fit.PointCovarianceM2(target, target.leds_m[i])};
      p.recovered_mask = static_cast<std::uint8_t>(p.recovered_mask | 1U << i);
    }
    p.leds_b_m[i] = all[i].point_b_m;
  }
  out.complete = p.recovered_mask == 0;
  p.status = out.complete ? FixStatus::kTracked : FixStatus::kRecovered;
  p.reason = LossReason::kNone;
  p.bar_m = (p.leds_b_m[3] - p.leds_b_m[0]).norm();
  p.bar_sigma_m = DistanceSigmaM(all[0], all[3]);
  p.epicenter_b_m = out.fit.PointM(target, target.epicenter_m);
  p.epicenter_covariance_m2 = out.fit.PointCovarianceM2(target, target.epicenter_m);
  p.direction_b = out.fit.bar.direction_b;
  p.direction_covariance = out.fit.DirectionCovariance();
  p.epicenter_direction_covariance_m = out.fit.PointDirectionCovarianceM(target, target.epicenter_m);
  // Rms over the coordinates that are seen; the others' residuals are zero.
  p.reprojection_px = std::sqrt(out.fit.residuals_px.squaredNorm() / (2 * SeenCount(observations)));
}

std::optional<Solution> Solver::Solve(const base::Target& target, const BarObservations& observations,
                                      LossReason& reason) const {
  reason = LossReason::kGeometry;
  LedPoints points, gated;
  LedPlaces leds_b_m = base::ZeroPoints<kLedCount>();
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!SeenInBoth(observations[i])) continue;
    const auto located = Triangulate(views_, observations[i]);
    if (!located) return std::nullopt;
    // The same place with the noise that the gates believe.
    const auto wider = LocatedAt(views_, observations[i], located->point_b_m, options_.centroid_floor_px);
    if (!wider) return std::nullopt;
    points[i] = *located;
    gated[i] = *wider;
    leds_b_m[i] = located->point_b_m;
  }
  const auto fit = FitBar(views_, target, observations, leds_b_m);
  if (!fit) return std::nullopt;
  reason = LossReason::kDistances;
  if (!DistancesFit(target, observations, gated)) return std::nullopt;
  Solution solution;
  solution.fit = *fit;
  const FitAllowance allowance{options_.centroid_floor_px, options_.epipolar_px / 2, options_.scale / 2};
  solution.chi_square = ChiSquare(views_, target, observations, *fit, allowance);
  const int seen = solution.seen = SeenCount(observations);
  if (!(solution.chi_square <= ChiSquareLimit(2 * seen - 5, options_.chi_square_sigmas))) return std::nullopt;
  solution.cost = solution.chi_square + options_.hidden_cost * (2 * kLedCount - seen);
  reason = LossReason::kNone;
  Fill(target, observations, points, solution);
  return solution;
}

}  // namespace adit::stereo
