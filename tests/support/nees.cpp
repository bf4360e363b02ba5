#include "tests/support/nees.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

namespace adit::support {

// Compiled here once: Eigen's solvers of fixed sizes take the compiler seconds in every test that names them.
double Nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factors(covariance);
  if (factors.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return error.dot(factors.solve(error));
}

Eigen::VectorXd Eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace adit::support
