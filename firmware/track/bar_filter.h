// One bar through time: a Kalman filter of constant velocity.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "firmware/base/time.h"
#include "firmware/track/bar_place.h"
#include "firmware/track/motion_options.h"

namespace adit::track {

/// The state is a point of the bar, its velocity, the bar's direction, and the direction's rate along a great
/// circle: x = (p, theta, v, u), 10 parameters, theta and u in the tangent plane of the direction. Between
/// measurements p' = p + v dt and theta' = theta + u dt, with white accelerations. Direction errors
/// live in the tangent plane, carried along by the smallest rotation (an error-state filter); the covariance
/// is updated in Joseph's form, P = (1 - K H) P (1 - K H)^T + K R K^T, which stays symmetric and positive.
///
/// Rig frame, metres. Trivially copyable; one thread; no allocation.
class BarFilter {
 public:
  /// Starts anew from one measurement: at rest, give or take what `options` believe of speeds.
  BarFilter(const MotionOptions& options, base::TimeNs exposure_ns, const BarPlace& measured);

  /// The state at a later exposure; one that is not later changes nothing.
  void Advance(base::TimeNs exposure_ns);

  /// Squared innovation in units of its covariance (NIS): chi-square, 5 degrees of freedom. Nothing if it has
  /// none: the bar points elsewhere altogether, or a number is not finite. `measured` is of the time of the
  /// last Advance, and must not have been made with this filter's help.
  std::optional<double> ChiSquare(const BarPlace& measured) const;
  /// Takes `measured` in. Call it only if ChiSquare has a value for it.
  void Update(const BarPlace& measured);

  base::TimeNs ExposureNs() const { return exposure_ns_; }
  /// With the covariance of the bar at ExposureNs().
  BarPlace Place() const;
  /// Trace of the point's covariance.
  double PointVarianceM2() const { return covariance_.topLeftCorner<3, 3>().trace(); }
  const Eigen::Vector3d& VelocityMPerS() const { return velocity_m_per_s_; }
  /// Of (p, theta, v, u).
  using Covariance = Eigen::Matrix<double, 10, 10>;
  const Covariance& GetCovariance() const { return covariance_; }
  /// d(direction)/dt
  Eigen::Vector3d DirectionRate() const { return Tangent() * rate_rad_per_s_; }
  /// The two directions that theta and u are measured along.
  Eigen::Matrix<double, 3, 2> Tangent() const { return basis_.rightCols<2>(); }

 private:
  using Innovation = Eigen::Matrix<double, 5, 1>;
  using InnovationCovariance = Eigen::Matrix<double, 5, 5>;

  std::optional<Innovation> InnovationOf(const BarPlace& measured) const;
  InnovationCovariance NoiseOf(const BarPlace& measured) const;
  void Turn(const Eigen::Vector2d& step_rad);

  MotionOptions options_;
  base::TimeNs exposure_ns_;
  Eigen::Vector3d point_b_m_;
  Eigen::Vector3d velocity_m_per_s_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d basis_;  ///< the direction and two directions across it
  Eigen::Vector2d rate_rad_per_s_ = Eigen::Vector2d::Zero();
  Covariance covariance_ = Covariance::Zero();
};

}  // namespace adit::track
