// A rig and a total station that measure the same five points; the truth in plain trigonometry, apart from
// the code under test.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "host/helmert.h"

namespace adit::test {

/// One survey with noise of known size.
class SurveyTruth {
 public:
  static inline const Eigen::Vector3d kRigSigmaM{0.0003, 0.0003, 0.0015};  // the distance is measured worst

  /// `control_sigma_m`: the noise of each coordinate of a control point.
  explicit SurveyTruth(unsigned seed, double control_sigma_m = 0.001)
      : random_(seed), control_sigma_m_(control_sigma_m) {
    heading_rad_ = Uniform(0, 6.28);
    pitch_rad_ = Uniform(-0.1, 0.1);
    roll_rad_ = Uniform(-0.05, 0.05);
    place_s_m_ = {Uniform(2.5e6, 2.8e6), Uniform(1.1e6, 1.3e6), Uniform(200, 2000)};
  }

  double Uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }

  /// Where a point of the rig frame is in the site grid: forward along the heading, right across it, down.
  Eigen::Vector3d Place(const Eigen::Vector3d& b) const {
    const double roll_x = b.x() * std::cos(roll_rad_) - b.y() * std::sin(roll_rad_);  // right
    const double roll_y = b.x() * std::sin(roll_rad_) + b.y() * std::cos(roll_rad_);  // down
    const double ahead = b.z() * std::cos(pitch_rad_) + roll_y * std::sin(pitch_rad_);
    const double down = roll_y * std::cos(pitch_rad_) - b.z() * std::sin(pitch_rad_);
    return place_s_m_ + Eigen::Vector3d(ahead * std::sin(heading_rad_) + roll_x * std::cos(heading_rad_),
                                        ahead * std::cos(heading_rad_) - roll_x * std::sin(heading_rad_),
                                        -down);
  }

  /// Five points as they are set out in a tunnel of 8 by 6 m, 25 to 65 m ahead: on both walls and in the
  /// roof.
  std::vector<host::CommonPoint> Measure() {
    const double walls[5][3] = {
        {-3.5, 0.5, 25}, {3.5, -0.5, 30}, {0, -2.5, 45}, {-3.5, -1, 55}, {3.5, 1, 65}};
    std::vector<host::CommonPoint> points;
    for (const auto& wall : walls) {
      const Eigen::Vector3d b(wall[0] + Uniform(-0.5, 0.5), wall[1] + Uniform(-0.5, 0.5),
                              wall[2] + Uniform(-4, 4));
      host::CommonPoint point;
      point.name = "P" + std::to_string(points.size() + 1);
      point.rig_b_m = b + kRigSigmaM.cwiseProduct(Noise());
      point.rig_covariance_m2 = kRigSigmaM.cwiseAbs2().asDiagonal();
      point.control_s_m = Place(b) + control_sigma_m_ * Noise();
      point.control_covariance_m2 = control_sigma_m_ * control_sigma_m_ * Eigen::Matrix3d::Identity();
      points.push_back(point);
    }
    return points;
  }

  Eigen::Vector3d Noise() {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
  double control_sigma_m_;
  std::normal_distribution<double> normal_;
  double heading_rad_ = 0, pitch_rad_ = 0, roll_rad_ = 0;
  Eigen::Vector3d place_s_m_ = Eigen::Vector3d::Zero();
};

}  // namespace adit::test
