// LEDs on a rigid bar, all four or what is seen of them -> where the bar is.
#pragma once

#include <array>
#include <optional>

#include "firmware/base/target.h"
#include "firmware/stereo/view.h"

namespace adit::stereo {

/// The centroids of LED 1 to LED 4 in both images; those that are hidden are marked so.
using BarObservations = std::array<ObservationPair, base::kLedCount>;
/// Places of LED 1 to LED 4.
using LedPlaces = std::array<Eigen::Vector3d, base::kLedCount>;

/// How many centroids there are; each is two coordinates.
int SeenCount(const BarObservations& observations);

/// Residuals of a bar: LED by LED, left before right, u before v; zero where nothing is seen.
using BarResiduals = Eigen::Matrix<double, 4 * base::kLedCount, 1>;

/// A bar in the rig frame: the mean place of its LEDs and its direction. The mean, because the estimate of
/// place and direction are then nearly uncorrelated.
struct Bar {
  Eigen::Vector3d centre_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::UnitX();  ///< unit, LED 1 to LED 4
};

/// A fitted bar.
struct BarFit {
  Bar bar;
  /// Of centre (3) and of direction (2, in the tangent plane `tangent`).
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 3, 2> tangent = Eigen::Matrix<double, 3, 2>::Zero();
  BarResiduals residuals_px = BarResiduals::Zero();  ///< seen minus measured

  /// The point `place_m` along the bar from LED 1, and its covariance.
  Eigen::Vector3d PointM(const base::Target& target, double place_m) const;
  Eigen::Matrix3d PointCovarianceM2(const base::Target& target, double place_m) const;
  /// Rank 2: a unit vector moves in its tangent plane only.
  Eigen::Matrix3d DirectionCovariance() const;
  /// Of that point (rows) with the direction (columns).
  Eigen::Matrix3d PointDirectionCovarianceM(const base::Target& target, double place_m) const;
};

/// Fits the rigid bar to the coordinates that are seen, weighted by the centroids' covariances: 5 parameters,
/// Levenberg-Marquardt from the line through those of `leds_b_m` that are seen in both images (the others are
/// not read). An LED seen in one image helps with its ray. Where a bar that leans towards the cameras and one
/// that leans away fit nearly alike, the better one is taken, and the covariance covers the other by its
/// likelihood. Declines fewer than two LEDs seen in both images,
/// bars that reach behind a camera and what does not converge.
std::optional<BarFit> FitBar(const Views& views, const base::Target& target,
                             const BarObservations& observations, const LedPlaces& leds_b_m);

/// What a calibration may be off by, and the centroids beyond their covariance; 1 sigma each.
struct FitAllowance {
  double centroid_px = 0;
  double right_image_px = 0;  ///< the right image as a whole, in u and in v: the rig has turned a little
  double scale = 0;           ///< of all distances
};

/// Chi-square of the fit's residuals, two degrees of freedom for each centroid seen less five, after the best
/// common shift of the right image and the best scale within `allowance` are taken out.
double ChiSquare(const Views& views, const base::Target& target, const BarObservations& observations,
                 const BarFit& fit, const FitAllowance& allowance);

}  // namespace adit::stereo
