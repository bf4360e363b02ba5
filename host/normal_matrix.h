// Normal matrices of least squares, of any size. Eigen compiles its solvers anew for every fixed size,
// seconds each; here they are compiled once.
#pragma once

#include <Eigen/Core>

namespace adit::host {

/// The normal matrix of the shared parameters with the own ones of the same residuals eliminated (Schur
/// complement): AᵀA - AᵀB (BᵀB)⁻¹ BᵀA for the Jacobians A by the shared and B by the own parameters, a row a
/// residual.
Eigen::MatrixXd ReducedNormalMatrix(const Eigen::MatrixXd& by_shared, const Eigen::MatrixXd& by_own);

/// The eigenvalues of a symmetric matrix, ascending, and its eigenvectors as columns in the same order.
struct Spectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
Spectrum SpectrumOf(const Eigen::MatrixXd& symmetric);

/// The inverse of a symmetric positive matrix.
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& symmetric);

/// The singular values of a matrix, descending, and its right singular vectors as columns in the same order.
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd right;
};
SingularValues SingularValuesOf(const Eigen::MatrixXd& matrix);

/// The shortest x of those with the least |matrix x - b|: where columns depend on each other, none of them is
/// preferred.
Eigen::VectorXd ShortestSolution(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& b);

}  // namespace adit::host
