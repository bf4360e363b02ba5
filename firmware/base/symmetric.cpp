#include "firmware/base/symmetric.h"

#include <Eigen/Cholesky>
#include <limits>

namespace adit::base {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

using Factors = Eigen::LDLT<SmallMatrix>;

/// Written so that NaN is not positive.
bool IsPositive(const Factors& factors) {
  return factors.vectorD().minCoeff() > 0 && factors.vectorD().allFinite();
}

/// Column by column: for matrices this small Eigen's blocked solution costs more than it saves.
void SolveColumns(const Factors& factors, const SmallView& b, Eigen::Map<Eigen::MatrixXd>& x) {
  for (Eigen::Index i = 0; i < b.cols(); ++i) x.col(i) = factors.solve(b.col(i));
}

}  // namespace

void SolveInto(const SmallView& s, const SmallView& b, Eigen::Map<Eigen::MatrixXd> x) {
  SolveColumns(Factors(s), b, x);
}

void InverseInto(const SmallView& s, Eigen::Map<Eigen::MatrixXd> inverse) {
  const Factors factors(s);
  if (!IsPositive(factors)) {
    inverse.setConstant(kNoValue);
    return;
  }
  const SmallMatrix one = SmallMatrix::Identity(s.rows(), s.cols());
  SolveColumns(factors, {one.data(), s.rows(), s.cols()}, inverse);
}

bool IsSemidefiniteOf(const SmallView& s, double tolerance) {
  SmallMatrix raised = s;
  raised.diagonal().array() += tolerance;
  const Factors factors(raised);
  return factors.vectorD().minCoeff() >= 0 && factors.vectorD().allFinite();
}

}  // namespace adit::base
