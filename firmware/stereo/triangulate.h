// Two centroids -> one point with covariance.
#pragma once

#include <optional>

#include "firmware/stereo/view.h"

namespace adit::stereo {

/// A point in the rig frame.
struct LocatedPoint {
  Eigen::Vector3d point_b_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Where a point's depth is this uncertain (1 sigma, share of the distance), its rays are parallel for all
/// practical purposes: linear propagation ends, and so does trust.
inline constexpr double kDepthSigmaMax = 0.05;

/// The point that reprojects best: from the rays' midpoint by Levenberg-Marquardt on the reprojection error
/// weighted by the covariances. (The thesis starts by SVD; the minimum is the same, and the SVD was 40 % of
/// the stage's time.) The covariance is the inverse of the normal matrix. `floor_px` is added to the
/// centroids' noise in quadrature. Declines rays that are nearly parallel or meet behind a camera, and what
/// does not converge.
std::optional<LocatedPoint> Triangulate(const Views& views, const ObservationPair& pair, double floor_px = 0);

/// The midpoint of the rays' closest approach. Declines rays that are parallel; it may be behind a camera.
std::optional<Eigen::Vector3d> Midpoint(const Views& views, const Eigen::Vector2d& left_px,
                                        const Eigen::Vector2d& right_px);

/// The midpoint of the rays' closest approach with its covariance: what a search needs, a tenth of the cost.
/// Declines as Triangulate does.
std::optional<LocatedPoint> TriangulateMidpoint(const Views& views, const ObservationPair& pair,
                                                double floor_px = 0);

}  // namespace adit::stereo
