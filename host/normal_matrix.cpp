#include "host/normal_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace adit::host {
namespace {

using Svd = Eigen::JacobiSVD<Eigen::MatrixXd>;

}  // namespace

Eigen::MatrixXd ReducedNormalMatrix(const Eigen::MatrixXd& by_shared, const Eigen::MatrixXd& by_own) {
  const Eigen::MatrixXd cross = by_own.transpose() * by_shared;
  const Eigen::MatrixXd own = by_own.transpose() * by_own;
  return by_shared.transpose() * by_shared - cross.transpose() * own.ldlt().solve(cross);
}

Spectrum SpectrumOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& symmetric) {
  return symmetric.ldlt().solve(Eigen::MatrixXd::Identity(symmetric.rows(), symmetric.cols()));
}

SingularValues SingularValuesOf(const Eigen::MatrixXd& matrix) {
  const Svd svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::VectorXd ShortestSolution(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& b) {
  return Svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV).solve(b);
}

}  // namespace adit::host
