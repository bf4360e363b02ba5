#include "host/data_snooping.h"

#include <Eigen/Cholesky>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

namespace adit::host {
namespace {

constexpr double kSignificance = 0.001;      // of the test of a single point or coordinate
constexpr double kModelSignificance = 0.05;  // of sigma0
constexpr double kRedundancyMin = 1e-6;      // below, w is rounding divided by rounding

double ChiSquared(int degrees, double significance) {
  return boost::math::quantile(
      boost::math::complement(boost::math::chi_squared(static_cast<double>(degrees)), significance));
}

void TestCoordinates(const Helmert& fit, const std::vector<CommonPoint>& points,
                     std::vector<PointTest>& tests) {
  const HelmertResiduals residuals = ResidualsOf(fit, points);
  const Eigen::VectorXd weighted = residuals.weights * residuals.residual_m;
  const Eigen::MatrixXd shares = residuals.covariance_m2 * residuals.weights;
  const Eigen::MatrixXd weighted_covariance = residuals.weights * shares;
  for (std::size_t i = 0; i < points.size(); ++i) {
    PointTest& test = tests[i];
    const auto first = static_cast<Eigen::Index>(3 * i);
    test.residual_m = residuals.residual_m.segment<3>(first);
    test.redundancy = shares.diagonal().segment<3>(first);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double variance = weighted_covariance(first + axis, first + axis);
      if (test.redundancy[axis] > kRedundancyMin && variance > 0)
        test.w[axis] = weighted[first + axis] / std::sqrt(variance);
    }
  }
}

/// Fits all points but `left_out`; its sigma0, or none if they do not determine a fit.
std::optional<double> LeaveOut(std::size_t left_out, const std::vector<CommonPoint>& points,
                               const HelmertOptions& options, PointTest& test) {
  std::vector<CommonPoint> others = points;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  const auto fit = FitHelmert(others, options);
  if (!fit) return std::nullopt;
  const CommonPoint& point = points[left_out];
  const Eigen::Vector3d residual_m = fit->Residual(point);
  const Eigen::Matrix<double, 3, 7> jacobian = fit->Jacobian(point.rig_b_m);
  const Eigen::Matrix3d covariance_m2 =
      fit->ObservationCovariance(point) + jacobian * fit->covariance * jacobian.transpose();
  test.left_out_m = residual_m;
  test.left_out_test = residual_m.dot(covariance_m2.llt().solve(residual_m));
  return fit->sigma0;
}

}  // namespace

Snooping Snoop(const std::vector<CommonPoint>& points, const Helmert& fit, const HelmertOptions& options) {
  Snooping out;
  out.tests.resize(points.size());
  out.w_critical = boost::math::quantile(boost::math::complement(boost::math::normal(), kSignificance / 2));
  out.left_out_critical = ChiSquared(3, kSignificance);
  if (fit.redundancy > 0)
    out.sigma0_critical = std::sqrt(ChiSquared(fit.redundancy, kModelSignificance) / fit.redundancy);
  TestCoordinates(fit, points, out.tests);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto sigma0 = LeaveOut(i, points, options, out.tests[i]);
    const bool is_worst =
        sigma0 && (!out.worst || out.tests[i].left_out_test > out.tests[*out.worst].left_out_test);
    if (!is_worst) continue;
    out.worst = i;
    out.sigma0_without_worst = *sigma0;
  }
  out.suspects_blunder = out.worst && out.tests[*out.worst].left_out_test > out.left_out_critical;
  return out;
}

}  // namespace adit::host
