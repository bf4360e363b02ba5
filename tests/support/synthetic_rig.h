// A rig and waved bars with known truth, projected by code of the tests' own.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace adit::tests {

/// Two cameras of 1400 x 1024 px without distortion that look at one point straight ahead of the middle of
/// their baseline. Geometry only; the left camera's frame is the world.
struct SyntheticRig {
  double focal_px = 3378, cu_px = 699.5, cv_px = 511.5;
  double width_px = 1400, height_px = 1024;
  Eigen::Matrix3d right_from_left = Eigen::Matrix3d::Identity();  ///< x_r = R x_l + t
  Eigen::Vector3d right_translation_m = Eigen::Vector3d::Zero();

  static SyntheticRig Convergent(double baseline_m, double meet_m) {
    const double toe_rad = std::atan(baseline_m / 2 / meet_m);
    SyntheticRig rig;
    // Seen from the left camera: the right one stands to the right, turned by twice the toe-in, and rolled
    // and pitched a little, as tripods are.
    rig.right_from_left = (Eigen::AngleAxisd(0.011, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(-0.007, Eigen::Vector3d::UnitX()) *
                           Eigen::AngleAxisd(2 * toe_rad, Eigen::Vector3d::UnitY()))
                              .toRotationMatrix();
    const Eigen::Vector3d centre_m(baseline_m * std::cos(toe_rad), 0.05, baseline_m * std::sin(toe_rad));
    rig.right_translation_m = -(rig.right_from_left * centre_m);
    return rig;
  }

  Eigen::Vector2d Left(const Eigen::Vector3d& p) const {
    return {focal_px * p.x() / p.z() + cu_px, focal_px * p.y() / p.z() + cv_px};
  }
  Eigen::Vector2d Right(const Eigen::Vector3d& p) const {
    return Left(right_from_left * p + right_translation_m);
  }
  bool Inside(const Eigen::Vector2d& px) const {
    return px.x() > 5 && px.y() > 5 && px.x() < width_px - 6 && px.y() < height_px - 6;
  }
};

/// A bar as it was held, and what both cameras measured of its LEDs.
struct SyntheticBar {
  std::array<Eigen::Vector3d, 4> leds_m;
  std::array<Eigen::Vector2d, 4> left_px, right_px;
};

/// Where the bars are waved.
struct Waving {
  double nearest_m = 15, farthest_m = 30;
  double lean_max = 0.7;  ///< of the direction's z
  double noise_px = 0.05;
  double reach = 1;  ///< share of the image around its centre that the bar reaches
};

inline double Uniform(std::mt19937_64& random, double from, double to) {
  return from + (to - from) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

inline double Gauss(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(1 - Uniform(random, 0, 1)));
  return radius * std::cos(2 * 3.14159265358979323846 * Uniform(random, 0, 1));
}

/// `count` bars that both cameras see entirely, LEDs at `places_m` from LED 1.
inline std::vector<SyntheticBar> WaveBars(const SyntheticRig& rig, const std::array<double, 4>& places_m,
                                          const Waving& waving, std::size_t count, std::mt19937_64& random) {
  std::vector<SyntheticBar> bars;
  while (bars.size() < count) {
    const double z = Uniform(random, waving.nearest_m, waving.farthest_m);
    const Eigen::Vector3d start(z * Uniform(random, -0.5, 0.5) * waving.reach * rig.width_px / rig.focal_px,
                                z * Uniform(random, -0.5, 0.5) * waving.reach * rig.height_px / rig.focal_px,
                                z);
    const double dz = Uniform(random, -waving.lean_max, waving.lean_max);
    const double turn = Uniform(random, 0, 2 * 3.14159265358979323846);
    const double flat = std::sqrt(1 - dz * dz);
    const Eigen::Vector3d direction(flat * std::cos(turn), flat * std::sin(turn), dz);
    SyntheticBar bar;
    bool seen = true;
    for (std::size_t i = 0; i < 4; ++i) {
      bar.leds_m[i] = start + places_m[i] * direction;
      bar.left_px[i] = rig.Left(bar.leds_m[i]);
      bar.right_px[i] = rig.Right(bar.leds_m[i]);
      seen = seen && rig.Inside(bar.left_px[i]) && rig.Inside(bar.right_px[i]);
      bar.left_px[i] += waving.noise_px * Eigen::Vector2d(Gauss(random), Gauss(random));
      bar.right_px[i] += waving.noise_px * Eigen::Vector2d(Gauss(random), Gauss(random));
    }
    if (seen) bars.push_back(bar);
  }
  return bars;
}

}  // namespace adit::tests
