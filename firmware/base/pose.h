// Frames of reference in the type: a product of poses compiles only if the inner frames agree.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>

namespace adit::base {

// Frames: cameras x right, y down, z forward, origin at the projection centre. FRAMES.md has a numeric
// example.
struct LeftCamera {};   ///< l
struct RightCamera {};  ///< r
struct Rig {};          ///< b, the left camera's frame
struct TargetFrame {};  ///< t, origin LED 1, x along the bar to LED 4
struct BodyFrame {};    ///< t of a body: x forward, y left, z up, origin as its file says
struct Site {};         ///< s, easting, northing, height

/// Rigid motion T_to_from: maps a point given in `From` to the same point given in `To`; metres.
template <class To, class From>
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point_m) const {
    return rotation * point_m + translation_m;
  }

  template <class Other>
  Pose<To, Other> operator*(const Pose<From, Other>& right) const {
    return {rotation * right.rotation, rotation * right.translation_m + translation_m};
  }

  Pose<From, To> Inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation_m)}; }
};

/// N points at the origin: Eigen leaves what it makes by default as it finds it.
template <std::size_t N>
std::array<Eigen::Vector3d, N> ZeroPoints() {
  std::array<Eigen::Vector3d, N> points;
  points.fill(Eigen::Vector3d::Zero());
  return points;
}

/// The cross product matrix [v]x.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace adit::base
