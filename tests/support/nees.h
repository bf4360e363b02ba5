// Whether stated covariances are true.
#pragma once

#include <Eigen/Core>

namespace adit::support {

/// Normalised estimation error squared, errorᵀ covariance⁻¹ error: chi-square with as many degrees of freedom
/// as the error has places if the covariance is its own. NaN if that is not positive.
double Nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

/// The eigenvalues of a symmetric matrix, ascending.
Eigen::VectorXd Eigenvalues(const Eigen::MatrixXd& symmetric);

}  // namespace adit::support
