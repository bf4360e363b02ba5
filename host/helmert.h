// The Helmert transformation from the rig frame into the site grid by least squares.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "firmware/base/result.h"

namespace adit::host {

/// One point measured in both frames, each time with its covariance.
struct CommonPoint {
  std::string name;
  Eigen::Vector3d rig_b_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rig_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d control_s_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d control_covariance_m2 = Eigen::Matrix3d::Identity();
};

/// What is estimated beside heading and translation.
struct HelmertOptions {
  bool estimate_tilt = true;  ///< false: the tilt is that of R_level_b
  bool estimate_scale = false;
  double grid_scale_factor = 1;
  /// Without the tilt: turns the rig frame into one with x right, y forward in the plane, z up. By default a
  /// camera whose x axis and optical axis are level.
  Eigen::Matrix3d R_level_b = (Eigen::Matrix3d() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished();

  int Parameters() const { return 4 + (estimate_tilt ? 2 : 0) + (estimate_scale ? 1 : 0); }
};

/// p_s = t_ref + m diag(k, k, 1) R (p_b - ref): k the grid scale factor, m the estimated scale.
struct Helmert {
  Eigen::Matrix3d R_s_b = Eigen::Matrix3d::Identity();
  double scale = 1;                                         ///< m
  double grid_scale_factor = 1;                             ///< k
  Eigen::Vector3d reference_b_m = Eigen::Vector3d::Zero();  ///< centroid of the points in the rig frame
  Eigen::Vector3d reference_s_m = Eigen::Vector3d::Zero();  ///< where the reference point comes to lie

  /// A priori, of (rotation vector in the site frame: rad, reference_s_m: m, scale); zero for what is given.
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  int redundancy = 0;  ///< observations minus parameters
  double sigma0 = 0;   ///< of unit weight, a posteriori; 1 if the sigmas are true. 0 without redundancy

  Eigen::Vector3d Apply(const Eigen::Vector3d& point_b_m) const;
  /// d p_s / d (the parameters in the order of `covariance`).
  Eigen::Matrix<double, 3, 7> Jacobian(const Eigen::Vector3d& point_b_m) const;
  /// Control minus transformed.
  Eigen::Vector3d Residual(const CommonPoint& point) const {
    return point.control_s_m - Apply(point.rig_b_m);
  }
  /// Of a residual whose point did not take part: both measurements, in the site frame.
  Eigen::Matrix3d ObservationCovariance(const CommonPoint& point) const;
};

/// The weighted fit: closed form (Umeyama 1991) to start, then Gauss-Newton, each point weighted by the
/// inverse of its ObservationCovariance. Declines (kFailed) with the reason: fewer than three points (two
/// without tilt), all in one place, on one line within what is measured (in plan without tilt, one place), or
/// a rotation that stays worse than 10 mrad. `points` need covariances that can be inverted.
base::Result<Helmert> FitHelmert(const std::vector<CommonPoint>& points, const HelmertOptions& options);

/// The weighted residuals' co-factors: for the tests of single observations.
struct HelmertResiduals {
  Eigen::VectorXd residual_m;     ///< E, N, H of the first point, then of the second ..
  Eigen::MatrixXd weights;        ///< block diagonal, 1/m^2
  Eigen::MatrixXd covariance_m2;  ///< a priori, of the residuals (Q_vv)
};
HelmertResiduals ResidualsOf(const Helmert& fit, const std::vector<CommonPoint>& points);

}  // namespace adit::host
