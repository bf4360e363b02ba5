#include "firmware/stereo/bar_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "firmware/stereo/levenberg_marquardt.h"

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector3d;

namespace {

using Tangent = Eigen::Matrix<double, 3, 2>;

double MeanPlaceM(const base::Target& target) {
  return (target.leds_m[0] + target.leds_m[1] + target.leds_m[2] + target.leds_m[3]) / kLedCount;
}

Tangent TangentOf(const Vector3d& direction) {
  Tangent tangent;
  tangent.col(0) = direction.unitOrthogonal();
  tangent.col(1) = direction.cross(tangent.col(0));
  return tangent;
}

/// Of the point `offset_m` from the centre by centre and direction.
Eigen::Matrix<double, 3, 5> PointSlope(const Tangent& tangent, double offset_m) {
  Eigen::Matrix<double, 3, 5> slope;
  slope << Eigen::Matrix3d::Identity(), offset_m * tangent;
  return slope;
}

/// The line through the LEDs seen in both images, by least squares; nothing if they have no common direction.
std::optional<Bar> LineThrough(const base::Target& target, const BarObservations& observations,
                               const LedPlaces& leds_b_m) {
  double count = 0, mean_place_m = 0;
  Vector3d mean_b_m = Vector3d::Zero();
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!SeenInBoth(observations[i])) continue;
    mean_b_m += leds_b_m[i], mean_place_m += target.leds_m[i];
    ++count;
  }
  if (count < 2) return std::nullopt;
  mean_b_m /= count, mean_place_m /= count;
  Vector3d direction = Vector3d::Zero();
  double spread_m2 = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (!SeenInBoth(observations[i])) continue;
    const double offset_m = target.leds_m[i] - mean_place_m;
    direction += offset_m * (leds_b_m[i] - mean_b_m);
    spread_m2 += offset_m * offset_m;
  }
  // On a bar of the target's length the sum is the spread; much less, and the LEDs have no common direction.
  constexpr double kShareMin = 0.1;
  if (!(direction.norm() > kShareMin * spread_m2)) return std::nullopt;
  direction.normalize();
  return Bar{mean_b_m + (MeanPlaceM(target) - mean_place_m) * direction, direction};
}

/// Whitened reprojection residuals of a bar: sixteen, zero where nothing is seen, so that the size is fixed.
struct BarProblem {
  static constexpr int kParameters = 5, kResiduals = 4 * kLedCount;
  using State = Bar;
  using Jacobian = Eigen::Matrix<double, kResiduals, kParameters>;
  const Views* views;
  const BarObservations* observations;
  std::array<double, kLedCount> offset_m;  ///< of each LED from the centre
  std::array<std::array<Eigen::Matrix2d, 2>, kLedCount> whiteners;

  BarProblem(const Views& both, const base::Target& target, const BarObservations& measured, double floor_px)
      : views(&both), observations(&measured) {
    for (std::size_t i = 0; i < kLedCount; ++i) {
      offset_m[i] = target.leds_m[i] - MeanPlaceM(target);
      for (std::size_t s = 0; s < 2; ++s) whiteners[i][s] = measured[i][s].Whitener(floor_px);
    }
  }

  /// Residuals in px and their derivatives, or both whitened.
  bool Linearise(const Bar& bar, bool whiten, BarResiduals& residuals, Jacobian& jacobian) const {
    const Tangent tangent = TangentOf(bar.direction_b);
    for (std::size_t i = 0; i < kLedCount; ++i) {
      const Vector3d point_m = bar.centre_b_m + offset_m[i] * bar.direction_b;
      for (std::size_t s = 0; s < 2; ++s) {
        Eigen::Vector2d seen;
        Eigen::Matrix<double, 2, 3> slope;
        if (!(*views)[s].Project(point_m, seen, slope)) return false;
        const auto row = static_cast<Eigen::Index>(4 * i + 2 * s);
        const double counts = (*observations)[i][s].seen ? 1 : 0;
        const Eigen::Matrix2d w = whiten ? whiteners[i][s] : counts * Eigen::Matrix2d::Identity();
        residuals.segment<2>(row) = w * (seen - (*observations)[i][s].px);
        const Eigen::Matrix<double, 2, 3> by_point = w * slope;
        jacobian.block<2, 3>(row, 0) = by_point;
        jacobian.block<2, 2>(row, 3) = offset_m[i] * by_point * tangent;
      }
    }
    return true;
  }

  bool Evaluate(const Bar& bar, BarResiduals& residuals, Jacobian& jacobian) const {
    return Linearise(bar, true, residuals, jacobian);
  }
  /// What the residuals bend the sum by: turned by t, an LED at offset o falls short by o t^2 / 2 along the
  /// bar. Only where that makes the sum steeper, or the matrix could lose its sign.
  void AddBend(const Bar& bar, const BarResiduals& residuals, const Jacobian& jacobian,
               Eigen::Matrix<double, kParameters, kParameters>& normal) const {
    double bend = 0;
    for (std::size_t i = 0; i < kLedCount; ++i) {
      const auto row = static_cast<Eigen::Index>(4 * i);
      bend -= offset_m[i] * residuals.segment<4>(row).dot(jacobian.block<4, 3>(row, 0) * bar.direction_b);
    }
    if (bend > 0) normal(3, 3) += bend, normal(4, 4) += bend;
  }
  Bar Moved(const Bar& bar, const Eigen::Matrix<double, 5, 1>& step) const {
    return {bar.centre_b_m + step.head<3>(),
            (bar.direction_b + TangentOf(bar.direction_b) * step.tail<2>()).normalized()};
  }
};

struct LocalMinimum {
  Bar bar;
  Minimum<BarProblem::kParameters> minimum;
};

/// Far away a bar's image tells how much it leans, but hardly whether towards the cameras or away: the fit
/// has a second minimum there, and a start on its side ends in it. That minimum, if it is one and near
/// enough in cost to matter.
std::optional<LocalMinimum> OtherLean(const BarProblem& problem, const Bar& bar, double cost) {
  constexpr double kMatters = 100;  // more, and the start was on the right side beyond doubt
  constexpr double kSame = 1;       // squared, in standard deviations: it is the same minimum
  const Vector3d towards = bar.centre_b_m.normalized();
  LocalMinimum other{bar, {}};
  other.bar.direction_b -= 2 * towards.dot(bar.direction_b) * towards;
  BarResiduals residuals;
  BarProblem::Jacobian jacobian;
  if (!problem.Evaluate(other.bar, residuals, jacobian)) return std::nullopt;
  if (residuals.squaredNorm() > cost + kMatters) return std::nullopt;
  other.minimum = Minimise(problem, other.bar);
  if (!other.minimum.converged) return std::nullopt;
  const Eigen::Vector2d turn =
      TangentOf(bar.direction_b).transpose() * (other.bar.direction_b - bar.direction_b);
  const Eigen::Matrix2d information = other.minimum.information.bottomRightCorner<2, 2>();
  if (turn.dot(information * turn) < kSame) return std::nullopt;
  return other;
}

}  // namespace

Vector3d BarFit::PointM(const base::Target& target, double place_m) const {
  return bar.centre_b_m + (place_m - MeanPlaceM(target)) * bar.direction_b;
}

Eigen::Matrix3d BarFit::PointCovarianceM2(const base::Target& target, double place_m) const {
  const auto by_parameters = PointSlope(tangent, place_m - MeanPlaceM(target));
  return by_parameters * covariance * by_parameters.transpose();
}

Eigen::Matrix3d BarFit::PointDirectionCovarianceM(const base::Target& target, double place_m) const {
  const auto by_parameters = PointSlope(tangent, place_m - MeanPlaceM(target));
  return by_parameters * covariance.rightCols<2>() * tangent.transpose();
}

Eigen::Matrix3d BarFit::DirectionCovariance() const {
  return tangent * covariance.bottomRightCorner<2, 2>() * tangent.transpose();
}

int SeenCount(const BarObservations& observations) {
  int count = 0;
  for (const ObservationPair& pair : observations) count += (pair[0].seen ? 1 : 0) + (pair[1].seen ? 1 : 0);
  return count;
}

std::optional<BarFit> FitBar(const Views& views, const base::Target& target,
                             const BarObservations& observations, const LedPlaces& leds_b_m) {
  const auto start = LineThrough(target, observations, leds_b_m);
  if (!start) return std::nullopt;
  BarFit fit;
  fit.bar = *start;
  const BarProblem problem(views, target, observations, 0);
  auto minimum = Minimise(problem, fit.bar);
  if (!minimum.converged) return std::nullopt;
  const auto other = OtherLean(problem, fit.bar, minimum.cost);
  Eigen::Matrix<double, 5, 1> apart = Eigen::Matrix<double, 5, 1>::Zero();
  double share = 0;
  if (other) {
    Bar second = other->bar;
    if (other->minimum.cost < minimum.cost) {
      std::swap(second, fit.bar);
      share = 1 / (1 + std::exp(0.5 * (minimum.cost - other->minimum.cost)));
      minimum = other->minimum;
    } else {
      share = 1 / (1 + std::exp(0.5 * (other->minimum.cost - minimum.cost)));
    }
    apart << second.centre_b_m - fit.bar.centre_b_m,
        TangentOf(fit.bar.direction_b).transpose() * (second.direction_b - fit.bar.direction_b);
  }
  fit.covariance = base::InversePositive(minimum.information) + share * apart * apart.transpose();
  if (!fit.covariance.allFinite()) return std::nullopt;
  fit.tangent = TangentOf(fit.bar.direction_b);
  BarProblem::Jacobian unused;
  problem.Linearise(fit.bar, false, fit.residuals_px, unused);
  return fit;
}

double ChiSquare(const Views& views, const base::Target& target, const BarObservations& observations,
                 const BarFit& fit, const FitAllowance& allowance) {
  // The allowances are further parameters with a prior. Minimising over them and the bar once more, to first
  // order, leaves r^T r - b^T N^-1 b: no second fit is needed.
  constexpr int kColumns = 8;  // bar 5, shift of the right image 2, scale 1
  const BarProblem problem(views, target, observations, allowance.centroid_px);
  BarResiduals residuals;
  BarProblem::Jacobian by_bar;
  if (!problem.Linearise(fit.bar, true, residuals, by_bar)) return HUGE_VAL;
  Eigen::Matrix<double, BarProblem::kResiduals, kColumns> by_all;
  by_all << by_bar, Eigen::Matrix<double, BarProblem::kResiduals, 3>::Zero();
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const auto row = static_cast<Eigen::Index>(4 * i);
    by_all.block<2, 2>(row + 2, 5) = problem.whiteners[i][1];
    // A larger bar: each LED moves out along the direction. by_bar's first three columns are by the point.
    by_all.block<4, 1>(row, 7) = by_bar.block<4, 3>(row, 0) * fit.bar.direction_b * problem.offset_m[i];
  }
  Eigen::Matrix<double, kColumns, kColumns> normal = base::Normal(by_all);
  const auto prior = [](double sigma) { return 1 / (sigma * sigma); };
  normal(5, 5) += prior(allowance.right_image_px);
  normal(6, 6) += prior(allowance.right_image_px);
  normal(7, 7) += prior(allowance.scale);
  const Eigen::Matrix<double, kColumns, 1> b = by_all.transpose().lazyProduct(residuals);
  return residuals.squaredNorm() - base::MahalanobisSquared(normal, b);
}

}  // namespace adit::stereo
