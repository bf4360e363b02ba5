#include "firmware/base/symmetric.h"

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::Congruence;
using adit::base::InversePositive;
using adit::base::InverseSymmetric;
using adit::base::MahalanobisSquared;
using adit::base::Normal;
using adit::base::SolvePositive;
using adit::base::SolveSymmetric;

namespace {

constexpr unsigned kMatrixSeed = 31;
constexpr int kSize = 6;

using Square = Eigen::Matrix<double, kSize, kSize>;
using Column = Eigen::Matrix<double, kSize, 1>;

template <int kRows, int kColumns>
Eigen::Matrix<double, kRows, kColumns> Random(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, kRows, kColumns> matrix;
  for (double& value : matrix.reshaped()) value = normal(random);
  return matrix;
}

/// Positive, its variances six orders of magnitude apart as metres and radians are.
Square Covariance(std::mt19937& random) {
  const Square root = Random<kSize, kSize>(random);
  Column scale;
  scale << 1, 1, 1, 1e-3, 1e-3, 1e-3;
  return scale.asDiagonal() * (root * root.transpose() + Square::Identity()) * scale.asDiagonal();
}

}  // namespace

TEST_GROUP(Symmetric){};

TEST(Symmetric, CongruenceIsTheSumOverAllPairs) {
  std::mt19937 random(kMatrixSeed);
  const Square p = Covariance(random);
  const auto a = Random<3, kSize>(random);
  const Eigen::Matrix3d moved = Congruence(a, p);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < kSize; ++k) {
        for (int l = 0; l < kSize; ++l) sum += a(i, k) * p(k, l) * a(j, l);
      }
      DOUBLES_EQUAL(sum, moved(i, j), 1e-12);
    }
  }
}

TEST(Symmetric, TheSolutionSolves) {
  std::mt19937 random(kMatrixSeed);
  for (int i = 0; i < 20; ++i) {
    const Square s = Covariance(random);
    const Eigen::Matrix<double, kSize, 4> b = s * Random<kSize, 4>(random);
    CHECK((s * SolveSymmetric(s, b) - b).norm() <= 1e-12 * b.norm());
    CHECK((s * SolvePositive(s, b) - b).norm() <= 1e-12 * b.norm());
    CHECK((s * InversePositive(s) - Square::Identity()).cwiseAbs().maxCoeff() <= 1e-9);
    CHECK((s * InverseSymmetric(s) - Square::Identity()).cwiseAbs().maxCoeff() <= 1e-9);
  }
}

TEST(Symmetric, NormalIsTheMatrixOfTheColumnsProducts) {
  std::mt19937 random(kMatrixSeed);
  const auto j = Random<16, 5>(random);
  const Eigen::Matrix<double, 5, 5> normal = Normal(j);
  for (int a = 0; a < 5; ++a) {
    for (int b = 0; b < 5; ++b) DOUBLES_EQUAL(j.col(a).dot(j.col(b)), normal(a, b), 1e-12);
  }
}

TEST(Symmetric, MahalanobisIsTheSumOfSquaresInUnitsOfSigma) {
  std::mt19937 random(kMatrixSeed);
  // error = root z, covariance = root rootᵀ: z is what was put in.
  const Square root = Random<kSize, kSize>(random);
  const Column z = Random<kSize, 1>(random);
  const Square covariance = root * root.transpose();
  const Column error = root * z;
  DOUBLES_EQUAL(z.squaredNorm(), MahalanobisSquared(covariance, error), 1e-9);
}

TEST(Symmetric, WhatIsNotPositiveHasNoInverse) {
  Square flat = Square::Identity();
  flat(4, 4) = 0;
  Square negative = Square::Identity();
  negative(4, 4) = -1;
  Square unknown = Square::Identity();
  unknown(4, 4) = std::nan("");
  for (const Square& s : {flat, negative, unknown}) {
    CHECK(InverseSymmetric(s).array().isNaN().all());
    CHECK(InversePositive(s).array().isNaN().all());
    CHECK(std::isnan(MahalanobisSquared(s, Column::Ones().eval())));
  }
}

TEST(Symmetric, SemidefiniteIsWhatHasNoEigenvalueBelowTheTolerance) {
  std::mt19937 random(kMatrixSeed);
  // Rank 5: one eigenvalue is zero; moved down by more than the tolerance, it is seen.
  const auto root = Random<kSize, 5>(random);
  const Square flat = root * root.transpose();
  CHECK(adit::base::IsSemidefinite(flat, 1e-9));
  CHECK(!adit::base::IsSemidefinite(Square(flat - 2e-9 * Square::Identity()), 1e-9));
  CHECK(adit::base::IsSemidefinite(Square::Zero().eval(), 0));
  Square unknown = flat;
  unknown(5, 5) = std::nan("");
  CHECK(!adit::base::IsSemidefinite(unknown, 1e-9));
}

TEST(Symmetric, TakesNoHeap) {
  std::mt19937 random(kMatrixSeed);
  const auto h = Random<5, 12>(random);
  const Eigen::Matrix<double, 12, 12> p = h.transpose() * h + Eigen::Matrix<double, 12, 12>::Identity();
  const std::uint64_t before = adit::support::AllocationCount();
  const Eigen::Matrix<double, 5, 5> s = Congruence(h, p);
  const Eigen::Matrix<double, 5, 12> x = SolveSymmetric(s, h);
  const Eigen::Matrix<double, 12, 12> inverse = InverseSymmetric(p);
  const Eigen::Matrix<double, 5, 12> plain = SolvePositive(s, h);
  const double distance = MahalanobisSquared(s, Eigen::Matrix<double, 5, 1>(x.col(0) + plain.col(0)));
  UNSIGNED_LONGS_EQUAL(0, adit::support::AllocationCount() - before);
  CHECK(std::isfinite(distance + inverse(0, 0)));
}
