// Sums over symmetric matrices of a few parameters: covariances and normal equations.
#pragma once

#include <Eigen/Core>

namespace adit::base {

/// The largest matrix that these functions take, rows or columns (the state of a body's filter has 12).
inline constexpr int kSymmetricMax = 12;

/// A matrix of at most kSymmetricMax rows and columns; its size is known at run time, and it needs no heap.
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSymmetricMax, kSymmetricMax>;
using SmallView = Eigen::Map<const Eigen::MatrixXd>;

// Eigen compiles its solvers and products anew for each size, seconds each; these are compiled once. No heap,
// any thread.
void CongruenceInto(const SmallView& a, const SmallView& p, Eigen::Map<Eigen::MatrixXd> out);
void SolveInto(const SmallView& s, const SmallView& b, Eigen::Map<Eigen::MatrixXd> x);
void InverseInto(const SmallView& s, Eigen::Map<Eigen::MatrixXd> inverse);
bool IsSemidefiniteOf(const SmallView& s, double tolerance);
double MahalanobisSquaredOf(const SmallView& s, const SmallView& error);

/// The view of a matrix of fixed size that the functions above take.
template <int kRows, int kColumns>
SmallView ViewOf(const Eigen::Matrix<double, kRows, kColumns>& matrix) {
  static_assert(kRows <= kSymmetricMax && kColumns <= kSymmetricMax);
  return {matrix.data(), kRows, kColumns};
}

/// a p aᵀ, the covariance of a x when p is that of x.
template <int kRows, int kColumns>
Eigen::Matrix<double, kRows, kRows> Congruence(const Eigen::Matrix<double, kRows, kColumns>& a,
                                               const Eigen::Matrix<double, kColumns, kColumns>& p) {
  Eigen::Matrix<double, kRows, kRows> out;
  CongruenceInto(ViewOf(a), ViewOf(p), {out.data(), kRows, kRows});
  return out;
}

/// The x of s x = b by LDLT with pivots; s symmetric, of which the lower triangle is read. Where a pivot is
/// zero, so is its part of x.
template <int kSize, int kColumns>
Eigen::Matrix<double, kSize, kColumns> SolveSymmetric(const Eigen::Matrix<double, kSize, kSize>& s,
                                                      const Eigen::Matrix<double, kSize, kColumns>& b) {
  Eigen::Matrix<double, kSize, kColumns> x;
  SolveInto(ViewOf(s), ViewOf(b), {x.data(), kSize, kColumns});
  return x;
}

/// errorᵀ s⁻¹ error, s positive and symmetric: chi-square with kSize degrees of freedom if s is the error's
/// covariance. NaN if s is not positive.
template <int kSize>
double MahalanobisSquared(const Eigen::Matrix<double, kSize, kSize>& s,
                          const Eigen::Matrix<double, kSize, 1>& error) {
  return MahalanobisSquaredOf(ViewOf(s), ViewOf(error));
}

/// s⁻¹, s positive and symmetric: NaN in all places if it is not.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> InverseSymmetric(const Eigen::Matrix<double, kSize, kSize>& s) {
  Eigen::Matrix<double, kSize, kSize> inverse;
  InverseInto(ViewOf(s), {inverse.data(), kSize, kSize});
  return inverse;
}

/// Whether no eigenvalue of the symmetric s is below -tolerance. False if a value is NaN.
template <int kSize>
bool IsSemidefinite(const Eigen::Matrix<double, kSize, kSize>& s, double tolerance) {
  return IsSemidefiniteOf(ViewOf(s), tolerance);
}

}  // namespace adit::base
