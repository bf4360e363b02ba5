// What the tests of the stereo room share: measurements of points and bars, and bounds on estimates of them.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "firmware/stereo/bar_fit.h"
#include "tests/support/synthetic_bar.h"

namespace adit::stereo_tests {

/// Both images of a point, with noise of `sigma_px` a coordinate on the ideal pixel.
inline stereo::ObservationPair Observe(const support::SyntheticRig& rig, const Eigen::Vector3d& point_b_m,
                                       double sigma_px, support::SyntheticScene& random) {
  stereo::ObservationPair pair;
  for (std::size_t side = 0; side < 2; ++side) {
    const support::SyntheticCamera& camera = side == 0 ? rig.left : rig.right;
    pair[side].px =
        camera.ProjectIdeal(point_b_m).value() + sigma_px * Eigen::Vector2d(random.Gauss(), random.Gauss());
    pair[side].covariance_px2 = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  }
  return pair;
}

inline stereo::BarObservations Observe(const support::SyntheticRig& rig, const support::SyntheticBar& bar,
                                       double sigma_px, support::SyntheticScene& random) {
  stereo::BarObservations all;
  for (std::size_t i = 0; i < base::kLedCount; ++i)
    all[i] = Observe(rig, bar.Point(bar.target.leds_m[i]), sigma_px, random);
  return all;
}

/// The Cramer-Rao bound of parameters that make points: the inverse Fisher information for Gaussian noise of
/// `sigma_px` on every coordinate, from numeric derivatives of the tests' own projection.
template <int kParameters>
Eigen::Matrix<double, kParameters, kParameters> CramerRao(
    const support::SyntheticRig& rig, double sigma_px,
    const std::function<std::vector<Eigen::Vector3d>(const Eigen::Matrix<double, kParameters, 1>&)>&
        points_of) {
  using Parameters = Eigen::Matrix<double, kParameters, 1>;
  constexpr double kStep = 1e-5;
  const auto pixels = [&](const Parameters& p) {
    const auto points = points_of(p);
    Eigen::VectorXd px(4 * points.size());
    Eigen::Index row = 0;
    for (const Eigen::Vector3d& point : points) {
      px.segment<2>(row) = rig.left.ProjectIdeal(point).value();
      px.segment<2>(row + 2) = rig.right.ProjectIdeal(point).value();
      row += 4;
    }
    return px;
  };
  Eigen::MatrixXd slopes(pixels(Parameters::Zero()).size(), kParameters);
  for (int i = 0; i < kParameters; ++i) {
    const Parameters step = kStep * Parameters::Unit(i);
    slopes.col(i) = (pixels(step) - pixels(-step)) / (2 * kStep);
  }
  return sigma_px * sigma_px * (slopes.transpose() * slopes).inverse();
}

}  // namespace adit::stereo_tests
