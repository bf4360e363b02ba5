// The essential matrix of two calibrated cameras from points alone, and the relative pose that it stands for.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "firmware/base/pose.h"

namespace adit::host {

/// x_r = R x_l + t.
using RelativePose = base::Pose<base::RightCamera, base::LeftCamera>;

/// One point in both images, normalised ideal coordinates (x/z, y/z).
struct RayPair {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
};

/// E with (right,1)^T E (left,1) = 0 by the normalised 8-point algorithm (Hartley 1997), its singular values
/// set to 1, 1, 0 (Hartley & Zisserman 9.6.1). Note that the four LEDs of a bar give three equations, not
/// four: along a line the constraint is a quadratic. Declines fewer than 8 points, and points that leave more
/// than one solution (rank below 8: all rays through one place, or one bar seen again and again).
std::optional<Eigen::Matrix3d> EssentialFromPoints(std::span<const RayPair> points);

/// Squared first-order geometric distance of a pair from the epipolar constraint (Sampson; Hartley &
/// Zisserman 11.4.3), normalised units: times the squared focal length it is px^2.
double SampsonSquared(const Eigen::Matrix3d& essential, const RayPair& pair);

/// The four poses of an essential matrix, |t| = 1 (Hartley & Zisserman 9.19).
std::array<RelativePose, 4> DecomposeEssential(const Eigen::Matrix3d& essential);

/// The point that is nearest to both rays, left camera frame, and its depths (z) in both cameras; in units of
/// the pose's translation. Declines rays that are parallel within 1e-6 rad.
struct Triangulated {
  Eigen::Vector3d point_l = Eigen::Vector3d::Zero();
  double depth_left = 0, depth_right = 0;
};
std::optional<Triangulated> Triangulate(const RelativePose& T_r_l, const RayPair& pair);

/// Of the four poses the one that has the points in front of both cameras. Declines if fewer than nine in ten
/// are, under the best one.
std::optional<RelativePose> ChoosePose(const Eigen::Matrix3d& essential, std::span<const RayPair> points);

}  // namespace adit::host
