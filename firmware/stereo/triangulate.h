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

/// The point that reprojects best, by the centroids' covariances: these are moved as little as makes their
/// rays meet (first-order corrections until none is left, Kanatani 1996, 6.2 and Lindstrom 2010), and the
/// point is where they do. Its covariance is that of LocatedAt. Declines rays that are nearly parallel or
/// meet behind a camera, and what does not converge.
std::optional<LocatedPoint> Triangulate(const Views& views, const ObservationPair& pair);

/// The point with the covariance that centroids there give it, the inverse of the normal matrix. `floor_px`
/// is added to their noise in quadrature. Declines points behind a camera and those of nearly parallel rays.
std::optional<LocatedPoint> LocatedAt(const Views& views, const ObservationPair& pair,
                                      const Eigen::Vector3d& point_b_m, double floor_px = 0);

/// The midpoint of the rays' closest approach. Declines rays that are parallel; it may be behind a camera.
std::optional<Eigen::Vector3d> Midpoint(const Views& views, const Eigen::Vector2d& left_px,
                                        const Eigen::Vector2d& right_px);

/// The midpoint of the rays' closest approach with its covariance: what a search needs.
/// Declines as Triangulate does.
std::optional<LocatedPoint> TriangulateMidpoint(const Views& views, const ObservationPair& pair,
                                                double floor_px = 0);

}  // namespace adit::stereo
