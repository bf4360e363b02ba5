#include "host/helmert.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/pose.h"
#include "firmware/base/rotation.h"
#include "host/normal_matrix.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kIterationsMax = 50;
constexpr double kConverged = 1e-12;           // rad, and relative to the extent of the points
constexpr double kRotationSigmaMaxRad = 0.01;  // 10 mm for each metre away from the points
constexpr double kFlat = 1e-9;                 // relative; nearer to a line is on it, but for rounding

Matrix3d GridScale(double k) { return Vector3d(k, k, 1).asDiagonal(); }

/// The points less their centroids; in the site frame with the grid scale taken out.
struct Centred {
  Vector3d centroid_b_m = Vector3d::Zero(), centroid_s_m = Vector3d::Zero();
  Eigen::Matrix3Xd rig_m, site_m;
};

Centred Centre(const std::vector<CommonPoint>& points, double grid_scale_factor) {
  Centred out;
  const auto count = static_cast<Eigen::Index>(points.size());
  out.rig_m.resize(3, count);
  out.site_m.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    out.rig_m.col(i) = points[static_cast<std::size_t>(i)].rig_b_m;
    out.site_m.col(i) = points[static_cast<std::size_t>(i)].control_s_m;
  }
  out.centroid_b_m = out.rig_m.rowwise().mean();
  out.centroid_s_m = out.site_m.rowwise().mean();
  out.rig_m.colwise() -= out.centroid_b_m;
  out.site_m.colwise() -= out.centroid_s_m;
  out.site_m = (GridScale(1 / grid_scale_factor) * out.site_m).eval();
  return out;
}

Matrix3d RotationBetween(const Eigen::Matrix3Xd& from_m, const Eigen::Matrix3Xd& to_m) {
  return base::NearestRotation(to_m * from_m.transpose());
}

/// The heading alone: the angle that the weighted sum of cross and dot products has in plan.
Matrix3d HeadingBetween(const Eigen::Matrix3Xd& level_m, const Eigen::Matrix3Xd& to_m) {
  const double dot = (level_m.topRows<2>().array() * to_m.topRows<2>().array()).sum();
  const double cross =
      (level_m.row(0).array() * to_m.row(1).array() - level_m.row(1).array() * to_m.row(0).array()).sum();
  return Eigen::AngleAxisd(std::atan2(cross, dot), Vector3d::UnitZ()).toRotationMatrix();
}

/// Columns of the full Jacobian that are estimated.
std::vector<Eigen::Index> Estimated(const HelmertOptions& options) {
  std::vector<Eigen::Index> columns;
  if (options.estimate_tilt) columns = {0, 1};
  for (const Eigen::Index column : {2, 3, 4, 5}) columns.push_back(column);
  if (options.estimate_scale) columns.push_back(6);
  return columns;
}

Helmert Start(const Centred& centred, const HelmertOptions& options) {
  Helmert fit;
  fit.grid_scale_factor = options.grid_scale_factor;
  fit.reference_b_m = centred.centroid_b_m;
  if (options.estimate_tilt) {
    fit.R_s_b = RotationBetween(centred.rig_m, centred.site_m);
  } else {
    fit.R_s_b = HeadingBetween(options.R_level_b * centred.rig_m, centred.site_m) * options.R_level_b;
  }
  if (options.estimate_scale) fit.scale = centred.site_m.norm() / centred.rig_m.norm();
  return fit;
}

struct NormalEquations {
  Eigen::Matrix<double, 7, 7> matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
  double weighted_squares = 0;
};

NormalEquations Sum(const Helmert& fit, const std::vector<CommonPoint>& points) {
  NormalEquations sums;
  for (const CommonPoint& point : points) {
    const Eigen::Matrix<double, 3, 7> jacobian = fit.Jacobian(point.rig_b_m);
    const Vector3d residual_m = fit.Residual(point);
    const Matrix3d weight = fit.ObservationCovariance(point).inverse();
    const Eigen::Matrix<double, 3, 7> weighted = weight * jacobian;
    sums.matrix += weighted.transpose().lazyProduct(jacobian);
    sums.right += weighted.transpose() * residual_m;
    sums.weighted_squares += residual_m.dot(weight * residual_m);
  }
  return sums;
}

void Step(const Eigen::Matrix<double, 7, 1>& step, Helmert& fit) {
  const Vector3d turn_rad = step.head<3>();
  if (const double angle_rad = turn_rad.norm(); angle_rad > 0)
    fit.R_s_b = Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad) * fit.R_s_b;
  fit.R_s_b = Eigen::Quaterniond(fit.R_s_b).normalized().toRotationMatrix();  // rounding does not add up
  fit.reference_s_m += step.segment<3>(3);
  fit.scale += step[6];
}

/// How far the points reach from where the rotation hinges (rms): from their line, or without tilt from the
/// vertical through their centroid.
double LeverM(const Centred& centred, const HelmertOptions& options) {
  const auto count = static_cast<double>(centred.rig_m.cols());
  if (!options.estimate_tilt)
    return (options.R_level_b * centred.rig_m).topRows<2>().norm() / std::sqrt(count);
  return SingularValuesOf(centred.rig_m.transpose()).values[1] / std::sqrt(count);
}

Error Refuse(const std::string& detail) { return {ErrorCode::kFailed, "", detail}; }

const char* WhereTheyLie(const HelmertOptions& options) {
  return options.estimate_tilt ? "on one line" : "in one place in plan";
}

base::Result<void> CheckGeometry(const std::vector<CommonPoint>& points, const Centred& centred,
                                 const HelmertOptions& options) {
  const std::size_t needed = options.estimate_tilt ? 3 : 2;
  if (points.size() < needed) {
    return Refuse(std::to_string(points.size()) + " common points; " + std::to_string(options.Parameters()) +
                  " parameters need at least " + std::to_string(needed));
  }
  if (LeverM(centred, options) > kFlat * centred.rig_m.norm()) return {};
  return Refuse(std::string("the common points lie ") + WhereTheyLie(options) +
                ", which leaves a rotation undetermined");
}

/// Refuses points that determine the rotation too badly to be of use.
base::Result<void> CheckRotation(const Helmert& fit, const Centred& centred, const HelmertOptions& options) {
  const double sigma_rad = std::sqrt(SpectrumOf(fit.covariance.topLeftCorner<3, 3>()).values.maxCoeff());
  if (sigma_rad <= kRotationSigmaMaxRad) return {};
  std::ostringstream text;
  text << "the common points lie " << WhereTheyLie(options) << " within " << LeverM(centred, options) * 1e3
       << " mm, so that a rotation keeps a sigma of " << sigma_rad * 1e3 << " mrad; at most "
       << kRotationSigmaMaxRad * 1e3 << " mrad is allowed";
  return Refuse(text.str());
}

/// Why points do not come together: the one whose distances to the others differ most from the rig's, by the
/// median, since a wrong point spoils only one of every other point's.
Error RefuseDivergence(const std::vector<CommonPoint>& points) {
  double worst_m = 0;
  std::string name;
  for (const CommonPoint& point : points) {
    std::vector<double> differences_m;
    for (const CommonPoint& other : points) {
      if (&other == &point) continue;
      differences_m.push_back(
          std::abs((point.control_s_m - other.control_s_m).norm() - (point.rig_b_m - other.rig_b_m).norm()));
    }
    const auto middle = differences_m.begin() + static_cast<std::ptrdiff_t>(differences_m.size() / 2);
    std::nth_element(differences_m.begin(), middle, differences_m.end());
    if (*middle > worst_m) worst_m = *middle, name = point.name;
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the adjustment does not converge: point " << name << " is "
       << worst_m << " m farther from or nearer to the others than the rig measured (median)";
  return Refuse(text.str());
}

}  // namespace

Vector3d Helmert::Apply(const Vector3d& point_b_m) const {
  return reference_s_m + scale * (GridScale(grid_scale_factor) * (R_s_b * (point_b_m - reference_b_m)));
}

Eigen::Matrix<double, 3, 7> Helmert::Jacobian(const Vector3d& point_b_m) const {
  const Vector3d turned_m = R_s_b * (point_b_m - reference_b_m);
  const Matrix3d grid = GridScale(grid_scale_factor);
  Eigen::Matrix<double, 3, 7> jacobian;
  jacobian.leftCols<3>() = -scale * grid * base::Skew(turned_m);
  jacobian.middleCols<3>(3).setIdentity();
  jacobian.col(6) = grid * turned_m;
  return jacobian;
}

Matrix3d Helmert::ObservationCovariance(const CommonPoint& point) const {
  const Matrix3d to_site = scale * GridScale(grid_scale_factor) * R_s_b;
  return point.control_covariance_m2 + to_site * point.rig_covariance_m2 * to_site.transpose();
}

base::Result<Helmert> FitHelmert(const std::vector<CommonPoint>& points, const HelmertOptions& options) {
  const Centred centred = Centre(points, options.grid_scale_factor);
  if (auto geometry = CheckGeometry(points, centred, options); !geometry) return geometry.error();
  // National coordinates have seven digits before the point: less their centroid, rounding does not keep the
  // steps from becoming small.
  std::vector<CommonPoint> near = points;
  for (CommonPoint& point : near) point.control_s_m -= centred.centroid_s_m;
  Helmert fit = Start(centred, options);
  const auto columns = Estimated(options);
  const double extent_m = centred.rig_m.norm();
  Eigen::MatrixXd inverse;
  bool converged = false;
  for (int iteration = 0; iteration < kIterationsMax && !converged; ++iteration) {
    const NormalEquations sums = Sum(fit, near);
    inverse = InverseOf(sums.matrix(columns, columns));
    Eigen::Matrix<double, 7, 1> step = Eigen::Matrix<double, 7, 1>::Zero();
    step(columns) = inverse * sums.right(columns);
    Step(step, fit);
    converged = step.head<3>().norm() < kConverged && std::abs(step[6]) < kConverged &&
                step.segment<3>(3).norm() < kConverged * extent_m;
  }
  fit.covariance(columns, columns) = inverse;
  if (auto rotation = CheckRotation(fit, centred, options); !rotation) return rotation.error();
  if (!converged) return RefuseDivergence(points);
  fit.redundancy = static_cast<int>(3 * points.size()) - options.Parameters();
  if (fit.redundancy > 0)
    fit.sigma0 = std::sqrt(Sum(fit, near).weighted_squares / static_cast<double>(fit.redundancy));
  fit.reference_s_m += centred.centroid_s_m;
  return fit;
}

HelmertResiduals ResidualsOf(const Helmert& fit, const std::vector<CommonPoint>& points) {
  const auto size = static_cast<Eigen::Index>(3 * points.size());
  HelmertResiduals out;
  out.residual_m.resize(size);
  out.weights = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd observations_m2 = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd jacobian(size, 7);
  for (Eigen::Index i = 0; i < size / 3; ++i) {
    const CommonPoint& point = points[static_cast<std::size_t>(i)];
    const Matrix3d covariance = fit.ObservationCovariance(point);
    out.residual_m.segment<3>(3 * i) = fit.Residual(point);
    jacobian.middleRows<3>(3 * i) = fit.Jacobian(point.rig_b_m);
    observations_m2.block<3, 3>(3 * i, 3 * i) = covariance;
    out.weights.block<3, 3>(3 * i, 3 * i) = covariance.inverse();
  }
  out.covariance_m2 = observations_m2 - jacobian * fit.covariance * jacobian.transpose();
  return out;
}

}  // namespace adit::host
