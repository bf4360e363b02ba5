// Truth for tests of the tracking: a bar that moves under random accelerations, and noisy measurements of it.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "firmware/track/bar_place.h"

namespace adit::tests {

/// Moves in steps of a millisecond; not the filter's arithmetic.
class SimulatedBar {
 public:
  explicit SimulatedBar(unsigned seed) : random_(seed) {}

  double Gauss() { return std::normal_distribution<double>()(random_); }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d Gauss3() { return {Gauss(), Gauss(), Gauss()}; }

  void StartAt(const Eigen::Vector3d& centre_m, double speed_m_per_s, double rate_rad_per_s) {
    centre_m_ = centre_m;
    velocity_m_per_s_ = speed_m_per_s * Gauss3();
    direction_ = Gauss3().normalized();
    spin_rad_per_s_ = rate_rad_per_s * Gauss3();
    spin_rad_per_s_ -= direction_.dot(spin_rad_per_s_) * direction_;  // a bar's own axis turns nothing
  }

  void Shift(const Eigen::Vector3d& by_m) { centre_m_ += by_m; }
  void TurnRound() { direction_ = -direction_; }
  void PlaceAt(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& direction) {
    centre_m_ = centre_m;
    direction_ = direction.normalized();
  }

  /// White accelerations of these powers, for `duration_s`.
  void Move(double duration_s, double acceleration, double turning) {
    const int steps = static_cast<int>(std::ceil(duration_s / 0.001));
    const double dt_s = duration_s / steps;
    for (int i = 0; i < steps; ++i) {
      // Half of a step's kick counts in it, or place and velocity are tied closer than in continuous time.
      const Eigen::Vector3d kick_m_per_s = acceleration * std::sqrt(dt_s) * Gauss3();
      centre_m_ += dt_s * (velocity_m_per_s_ + 0.5 * kick_m_per_s);
      velocity_m_per_s_ += kick_m_per_s;
      Eigen::Vector3d kick_rad_per_s = turning * std::sqrt(dt_s) * Gauss3();
      kick_rad_per_s -= direction_.dot(kick_rad_per_s) * direction_;
      direction_ += dt_s * (spin_rad_per_s_ + 0.5 * kick_rad_per_s).cross(direction_);
      spin_rad_per_s_ += kick_rad_per_s;
      direction_.normalize();
    }
  }

  /// Point `along_m` from the centre, with noise: of the centre in three axes, of the direction across it,
  /// and of both together as far as the point is off the centre.
  track::BarPlace Measure(const Eigen::Vector3d& centre_sigma_m, double direction_sigma_rad,
                          double along_m = 0) {
    const Eigen::Vector3d centre_m = centre_m_ + centre_sigma_m.cwiseProduct(Gauss3());
    Eigen::Vector3d turn = direction_sigma_rad * Gauss3();
    turn -= direction_.dot(turn) * direction_;
    const Eigen::Vector3d direction = (direction_ + turn).normalized();
    const Eigen::Matrix3d across = direction_sigma_rad * direction_sigma_rad *
                                   (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    track::BarPlace place{centre_m + along_m * direction, direction, {}};
    const Eigen::Matrix3d of_centre = centre_sigma_m.cwiseAbs2().asDiagonal();
    place.covariance << of_centre + along_m * along_m * across, along_m * across, along_m * across, across;
    return place;
  }

  const Eigen::Vector3d& CentreM() const { return centre_m_; }
  const Eigen::Vector3d& VelocityMPerS() const { return velocity_m_per_s_; }
  const Eigen::Vector3d& Direction() const { return direction_; }
  Eigen::Vector3d DirectionRate() const { return spin_rad_per_s_.cross(direction_); }

 private:
  std::mt19937_64 random_;
  Eigen::Vector3d centre_m_, velocity_m_per_s_, direction_, spin_rad_per_s_;
};

}  // namespace adit::tests
