// One body through time: a Kalman filter of constant velocity over six degrees of freedom.
#pragma once

#include <Eigen/Core>

#include "firmware/base/time.h"
#include "firmware/track/body_fit.h"
#include "firmware/track/motion_options.h"

namespace adit::track {

/// The state is the middle of the bars, the rotation of the body, and the rates of both: x = (p, theta,
/// v, w), 12 parameters, theta a small rotation in the axes of b (an error-state filter). It moves as
/// BarFilter does, and takes single bars in: one alone leaves the turn around it to the filter.
///
/// Rig frame, metres. One thread; no allocation.
class BodyFilter {
 public:
  /// Starts anew from a pose: at rest, give or take what `motion` believes of speeds.
  BodyFilter(const MotionOptions& motion, base::TimeNs exposure_ns, const Body& body, const BodyPose& pose);

  /// The state at a later exposure; one that is not later changes nothing.
  void Advance(base::TimeNs exposure_ns);

  /// Takes a bar in, seen by its centre at the time of the last Advance. False, and nothing taken in, if it
  /// is not where it can be (MotionOptions::chi_square_max).
  bool Take(const Body& body, const BodyBar& bar, const BarPlace& seen);

  base::TimeNs ExposureNs() const { return exposure_ns_; }
  BodyPose Pose(const Body& body) const;
  /// Where a bar is expected, by its centre.
  BarPlace PlaceOf(const Body& body, const BodyBar& bar) const;

 private:
  using Covariance = Eigen::Matrix<double, 12, 12>;
  Eigen::Matrix<double, 6, 6> PlacementCovariance() const;

  MotionOptions motion_;
  base::TimeNs exposure_ns_;
  Placement at_;
  Eigen::Vector3d velocity_m_per_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_rad_per_s_ = Eigen::Vector3d::Zero();
  Covariance covariance_ = Covariance::Zero();
};

}  // namespace adit::track
