// Where a bar is, with the covariance of all that is known of it: what the filter and the bodies work with.
#pragma once

#include <Eigen/Core>

#include "firmware/base/target.h"
#include "firmware/stereo/point_set.h"

namespace adit::track {

/// One point of a bar and the bar's direction, rig frame b, metres.
struct BarPlace {
  Eigen::Vector3d point_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::UnitX();  ///< unit, LED 1 to LED 4
  /// Of (point, direction); the direction's part has rank 2.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  /// The same bar by its point `along_m` further towards LED 4.
  BarPlace Moved(double along_m) const {
    BarPlace moved{point_b_m + along_m * direction_b, direction_b, covariance};
    // (1 a; 0 1) times the covariance times its transpose, block by block.
    const Eigen::Matrix3d across = along_m * covariance.bottomRightCorner<3, 3>();
    const Eigen::Matrix3d mixed = covariance.topRightCorner<3, 3>();
    moved.covariance.topLeftCorner<3, 3>() += along_m * (mixed + mixed.transpose() + across);
    moved.covariance.topRightCorner<3, 3>() += across;
    moved.covariance.bottomLeftCorner<3, 3>() += across.transpose();
    return moved;
  }
};

/// The mean place of the LEDs along the bar, from LED 1: there place and direction hardly depend on each
/// other.
inline double CentreM(const base::Target& target) {
  return (target.leds_m[0] + target.leds_m[1] + target.leds_m[2] + target.leds_m[3]) / base::kLedCount;
}

/// The epicenter and the direction as measured.
inline BarPlace MeasuredPlace(const stereo::TargetPoints& points) {
  BarPlace place{points.epicenter_b_m, points.direction_b, {}};
  place.covariance << points.epicenter_covariance_m2, points.epicenter_direction_covariance_m,
      points.epicenter_direction_covariance_m.transpose(), points.direction_covariance;
  return place;
}

}  // namespace adit::track
