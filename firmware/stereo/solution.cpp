#include "firmware/stereo/solution.h"

#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector3d;

namespace {

double DistanceSigmaM(const LocatedPoint& a, const LocatedPoint& b) {
  const Vector3d along = (b.point_b_m - a.point_b_m).normalized();
  return std::sqrt(along.dot((a.covariance_m2 + b.covariance_m2) * along));
}

void FillFromFit(const base::Target& target, const BarFit& fit, TargetPoints& out) {
  out.epicenter_b_m = fit.PointM(target, target.epicenter_m);
  out.epicenter_covariance_m2 = fit.PointCovarianceM2(target, target.epicenter_m);
  out.direction_b = fit.bar.direction_b;
  out.direction_covariance = fit.DirectionCovariance();
  out.epicenter_direction_covariance_m = fit.PointDirectionCovarianceM(target, target.epicenter_m);
  // Two coordinates make one distance in the image: rms over the eight centroids' distances' components.
  out.reprojection_px =
      std::sqrt(fit.residuals_px.squaredNorm() / static_cast<double>(fit.residuals_px.size()));
}

}  // namespace

bool DistanceFits(const LocatedPoint& a, const LocatedPoint& b, double expected_m,
                  const LocatorOptions& options) {
  const double distance_m = (b.point_b_m - a.point_b_m).norm();
  // Written so that NaN (two points at one place) does not fit.
  return std::abs(distance_m - expected_m) <=
         options.scale * expected_m + options.sigmas * DistanceSigmaM(a, b);
}

bool Solver::DistancesFit(const base::Target& target, const LedPoints& points) const {
  const auto fits = [&](std::size_t i, std::size_t j) {
    return DistanceFits(points[i], points[j], target.leds_m[j] - target.leds_m[i], options_);
  };
  return fits(0, 1) && fits(1, 2) && fits(2, 3) && fits(0, 3);
}

std::optional<Solution> Solver::Solve(const base::Target& target, const BarObservations& observations,
                                      LossReason& reason) const {
  reason = LossReason::kGeometry;
  LedPoints points, gated;
  std::array<Vector3d, kLedCount> leds_b_m;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const auto located = Triangulate(views_, observations[i]);
    // The same place with the noise that the gates believe.
    const auto wider = TriangulateMidpoint(views_, observations[i], options_.centroid_floor_px);
    if (!located || !wider) return std::nullopt;
    points[i] = *located;
    gated[i] = {located->point_b_m, wider->covariance_m2};
    leds_b_m[i] = located->point_b_m;
  }
  const auto fit = FitBar(views_, target, observations, leds_b_m);
  if (!fit) return std::nullopt;
  reason = LossReason::kDistances;
  if (!DistancesFit(target, gated)) return std::nullopt;
  Solution solution;
  const FitAllowance allowance{options_.centroid_floor_px, options_.epipolar_px / 2, options_.scale / 2};
  solution.chi_square = ChiSquare(views_, target, observations, *fit, allowance);
  if (!(solution.chi_square <= options_.chi_square_max)) return std::nullopt;
  reason = LossReason::kNone;
  TargetPoints& out = solution.points;
  out.status = FixStatus::kTracked;
  out.reason = LossReason::kNone;
  out.leds_b_m = leds_b_m;
  out.bar_m = (leds_b_m[3] - leds_b_m[0]).norm();
  out.bar_sigma_m = DistanceSigmaM(points[0], points[3]);
  FillFromFit(target, *fit, out);
  return solution;
}

}  // namespace adit::stereo
