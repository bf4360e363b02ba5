// Sums over symmetric matrices of a few parameters: covariances and normal equations.
#pragma once

#include <Eigen/Core>
#include <limits>

namespace adit::base {

/// The largest matrix that these functions take, rows or columns (the state of a body's filter has 12).
inline constexpr int kSymmetricMax = 12;

/// A matrix of at most kSymmetricMax rows and columns; its size is known at run time, and it needs no heap.
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSymmetricMax, kSymmetricMax>;
using SmallView = Eigen::Map<const Eigen::MatrixXd>;

// Eigen compiles its solvers and products anew for each size, seconds each. These are compiled once, but for
// those that every pair of images calls many times: plain loops, which the compiler reads in no time. No
// heap, any thread.
void SolveInto(const SmallView& s, const SmallView& b, Eigen::Map<Eigen::MatrixXd> x);
void InverseInto(const SmallView& s, Eigen::Map<Eigen::MatrixXd> inverse);
bool IsSemidefiniteOf(const SmallView& s, double tolerance);

/// The view of a matrix of fixed size that the functions above take.
template <int kRows, int kColumns>
SmallView ViewOf(const Eigen::Matrix<double, kRows, kColumns>& matrix) {
  static_assert(kRows <= kSymmetricMax && kColumns <= kSymmetricMax);
  return {matrix.data(), kRows, kColumns};
}

/// a p aᵀ, the covariance of a x when p is that of x; symmetric.
template <int kRows, int kColumns>
Eigen::Matrix<double, kRows, kRows> Congruence(const Eigen::Matrix<double, kRows, kColumns>& a,
                                               const Eigen::Matrix<double, kColumns, kColumns>& p) {
  Eigen::Matrix<double, kRows, kRows> out;
  for (int i = 0; i < kRows; ++i) {
    Eigen::Matrix<double, 1, kColumns> row = Eigen::Matrix<double, 1, kColumns>::Zero();
    for (int k = 0; k < kColumns; ++k) {
      for (int l = 0; l < kColumns; ++l) row[l] += a(i, k) * p(l, k);
    }
    for (int j = 0; j <= i; ++j) {
      double sum = 0;
      for (int l = 0; l < kColumns; ++l) sum += row[l] * a(j, l);
      out(i, j) = out(j, i) = sum;
    }
  }
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

/// The x of s x = b, s positive and symmetric, of which the lower triangle is read: a tenth of the cost of
/// SolveSymmetric. NaN in all places if s is not positive.
template <int kSize, int kColumns>
Eigen::Matrix<double, kSize, kColumns> SolvePositive(const Eigen::Matrix<double, kSize, kSize>& s,
                                                     const Eigen::Matrix<double, kSize, kColumns>& b) {
  // s = L D Lᵀ; then L y = b, and Lᵀ x = D⁻¹ y, a row of all columns at a time.
  Eigen::Matrix<double, kSize, kSize> factor;
  Eigen::Matrix<double, kSize, 1> inverse_pivot;
  Eigen::Matrix<double, kColumns, kSize> x = b.transpose();
  for (int i = 0; i < kSize; ++i) {
    double pivot = s(i, i);
    for (int j = 0; j < i; ++j) {
      double scaled = s(i, j);
      for (int k = 0; k < j; ++k) scaled -= factor(i, k) * factor(k, j);
      factor(j, i) = scaled;  // above the diagonal L D's transpose
      factor(i, j) = scaled * inverse_pivot[j];
      pivot -= factor(i, j) * scaled;
      for (int c = 0; c < kColumns; ++c) x(c, i) -= factor(i, j) * x(c, j);
    }
    // Written so that NaN is not positive.
    if (!(pivot > 0))
      return Eigen::Matrix<double, kSize, kColumns>::Constant(std::numeric_limits<double>::quiet_NaN());
    inverse_pivot[i] = 1 / pivot;
  }
  for (int i = kSize - 1; i >= 0; --i) {
    for (int c = 0; c < kColumns; ++c) x(c, i) *= inverse_pivot[i];
    for (int j = i + 1; j < kSize; ++j) {
      for (int c = 0; c < kColumns; ++c) x(c, i) -= factor(j, i) * x(c, j);
    }
  }
  return x.transpose();
}

/// s⁻¹ as SolvePositive gives it.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> InversePositive(const Eigen::Matrix<double, kSize, kSize>& s) {
  return SolvePositive<kSize, kSize>(s, Eigen::Matrix<double, kSize, kSize>::Identity());
}

/// jᵀ j.
template <int kRows, int kColumns>
Eigen::Matrix<double, kColumns, kColumns> Normal(const Eigen::Matrix<double, kRows, kColumns>& j) {
  Eigen::Matrix<double, kColumns, kColumns> out;
  for (int a = 0; a < kColumns; ++a) {
    for (int b = 0; b <= a; ++b) out(a, b) = out(b, a) = j.col(a).dot(j.col(b));
  }
  return out;
}

/// errorᵀ s⁻¹ error, s positive and symmetric: chi-square with kSize degrees of freedom if s is the error's
/// covariance. NaN if s is not positive.
template <int kSize>
double MahalanobisSquared(const Eigen::Matrix<double, kSize, kSize>& s,
                          const Eigen::Matrix<double, kSize, 1>& error) {
  // s = L D Lᵀ, row by row; L⁻¹ error has the variances D.
  Eigen::Matrix<double, kSize, kSize> factor;
  Eigen::Matrix<double, kSize, 1> pivot, rest = error;
  double sum = 0;
  for (int i = 0; i < kSize; ++i) {
    pivot[i] = s(i, i);
    for (int j = 0; j < i; ++j) {
      double scaled = s(i, j);
      for (int k = 0; k < j; ++k) scaled -= factor(i, k) * pivot[k] * factor(j, k);
      factor(i, j) = scaled / pivot[j];
      pivot[i] -= factor(i, j) * scaled;
      rest[i] -= factor(i, j) * rest[j];
    }
    // Written so that NaN is not positive.
    if (!(pivot[i] > 0)) return std::numeric_limits<double>::quiet_NaN();
    sum += rest[i] * rest[i] / pivot[i];
  }
  return sum;
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
