// Truth for tests of bodies: a loader with bars on it, and noisy measurements of them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>
#include <string>
#include <vector>

#include "firmware/track/body_fit.h"

namespace adit::tests {

inline const std::vector<base::Target> kBars{{"bar_a", {0, 0.25, 0.65, 1.5}, 0.4, 0.04},
                                             {"bar_b", {0, 0.55, 0.8, 1.5}, -0.3, 0.04},
                                             {"bar_c", {0, 0.4, 0.5, 1.0}, 1.2, 0.04}};

/// Two bars on the back of a loader, or three.
inline track::Body Loader(std::size_t bars) {
  track::Body body;
  body.name = "loader";
  const std::array<Eigen::Vector3d, 3> at_m{Eigen::Vector3d(-2, 1.6, 1.2), {-2, -0.2, 1.5}, {-2.2, 0.3, 2.4}};
  const std::array<Eigen::Vector3d, 3> directions{
      Eigen::Vector3d(0.05, -0.94, 0.33), {0, -0.92, -0.37}, {0.1, -0.98, 0.1}};
  for (std::size_t i = 0; i < bars; ++i) {
    track::BodyBar bar;
    bar.target = static_cast<std::uint8_t>(i);
    bar.led1_t_m = at_m[i];
    bar.direction_t = directions[i].normalized();
    bar.centre_m = track::CentreM(kBars[i]);
    bar.length_m = kBars[i].LengthM();
    body.bars.push_back(bar);
  }
  return body;
}

/// How well one bar is seen.
struct BarNoise {
  Eigen::Vector3d centre_sigma_m{3e-4, 3e-4, 1.5e-3};
  double direction_sigma_rad = 1e-3;
};

class SimulatedBody {
 public:
  SimulatedBody(const track::Body& drawn, unsigned seed) : body(drawn), built(drawn), random_(seed) {
    // The machine that was built is not the machine of the drawing.
    for (track::BodyBar& bar : built.bars) {
      const Eigen::Vector3d first_m = drawn.sigma_m * Gauss3(), last_m = drawn.sigma_m * Gauss3();
      const Eigen::Vector3d centre_m = bar.CentreM() + 0.5 * (first_m + last_m);
      bar.direction_t = (bar.direction_t + (last_m - first_m) / bar.length_m).normalized();
      bar.led1_t_m = centre_m - bar.centre_m * bar.direction_t;
    }
    // About as it drives away from the cameras: forward is z of the rig, left -x, up -y.
    T_b_t.rotation << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    Turn(0.3 * Gauss3());
    T_b_t.translation_m = {2, 1, 50};
  }

  double Gauss() { return std::normal_distribution<double>()(random_); }
  Eigen::Vector3d Gauss3() { return {Gauss(), Gauss(), Gauss()}; }
  void Turn(const Eigen::Vector3d& by_rad) {
    T_b_t.rotation =
        Eigen::AngleAxisd(by_rad.norm(), by_rad.normalized()).toRotationMatrix() * T_b_t.rotation;
  }
  Eigen::Vector3d Point(const track::BodyBar& bar, double along_m) const {
    return T_b_t * (bar.led1_t_m + along_m * bar.direction_t);
  }

  /// Bar `i` by its point `along_m` from LED 1.
  track::BarPlace Measure(std::size_t i, const BarNoise& noise, double along_m) {
    const track::BodyBar& bar = built.bars[i];
    const Eigen::Vector3d direction = T_b_t.rotation * bar.direction_t;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    track::BarPlace place;
    place.point_b_m = Point(bar, bar.centre_m) + noise.centre_sigma_m.cwiseProduct(Gauss3());
    place.direction_b = (direction + noise.direction_sigma_rad * across * Gauss3()).normalized();
    place.covariance.topLeftCorner<3, 3>() = noise.centre_sigma_m.cwiseAbs2().asDiagonal();
    place.covariance.bottomRightCorner<3, 3>() = std::pow(noise.direction_sigma_rad, 2) * across;
    return place.Moved(along_m - bar.centre_m);
  }

  track::Body body, built;  ///< as drawn, as it is
  base::Pose<base::Rig, base::BodyFrame> T_b_t;

 private:
  std::mt19937_64 random_;
};

}  // namespace adit::tests
