// Which control point is wrong: the tests that surveyors know.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/helmert.h"

namespace adit::host {

/// What the tests say of one point. Residuals are control minus transformed, E, N, H in metres.
struct PointTest {
  Eigen::Vector3d residual_m = Eigen::Vector3d::Zero();
  /// Baarda's w of each coordinate: standard normal if nothing is wrong. Zero where the redundancy is too
  /// small to tell.
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Vector3d redundancy = Eigen::Vector3d::Zero();  ///< 0 (unchecked) to 1 (fully checked)
  /// The residual at a fit to all other points; none if these do not determine one.
  std::optional<Eigen::Vector3d> left_out_m;
  /// Its square, weighted by its own covariance: chi-square with 3 degrees of freedom if nothing is wrong.
  double left_out_test = 0;
};

struct Snooping {
  std::vector<PointTest> tests;      ///< in the order of the points
  double w_critical = 0;             ///< two-sided, 0.1 %
  double left_out_critical = 0;      ///< 0.1 %
  double sigma0_critical = 0;        ///< one-sided, 5 %; 0 without redundancy
  std::optional<std::size_t> worst;  ///< the largest left_out_test; none if no point can be left out
  bool suspects_blunder = false;     ///< the worst one's test is above its critical value
  double sigma0_without_worst = 0;
};

/// Tests every point of a fit (Baarda 1968; significance 0.1 % as in his B-method). The sigmas of the points
/// must be true: they are what residuals are compared with. A blunder smears over all residuals; the test of
/// the point left out is the one that finds the point.
Snooping Snoop(const std::vector<CommonPoint>& points, const Helmert& fit, const HelmertOptions& options);

}  // namespace adit::host
