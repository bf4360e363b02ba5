#include "host/normal_matrix.h"

#include <Eigen/Core>
#include <random>

#include <CppUTest/TestHarness.h>

using adit::host::InverseOf;
using adit::host::ReducedNormalMatrix;
using adit::host::ShortestSolution;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr unsigned kSeed = 17;

MatrixXd Random(Eigen::Index rows, Eigen::Index columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

}  // namespace

TEST_GROUP(NormalMatrix){};

TEST(NormalMatrix, WithoutTheOwnParametersIsTheInverseOfTheSharedOnesCovariance) {
  std::mt19937 random(kSeed);
  const MatrixXd by_shared = Random(16, 7, random), by_own = Random(16, 5, random);
  MatrixXd all(16, 12);
  all << by_shared, by_own;
  const MatrixXd covariance = InverseOf(all.transpose() * all);
  const MatrixXd product = ReducedNormalMatrix(by_shared, by_own) * covariance.topLeftCorner(7, 7);
  CHECK((product - MatrixXd::Identity(7, 7)).norm() < 1e-9);
}

TEST(NormalMatrix, TheSpectrumMakesTheMatrixAgain) {
  std::mt19937 random(kSeed);
  const MatrixXd root = Random(5, 5, random), symmetric = root * root.transpose();
  const auto spectrum = adit::host::SpectrumOf(symmetric);
  CHECK((spectrum.vectors * spectrum.values.asDiagonal() * spectrum.vectors.transpose() - symmetric).norm() <
        1e-12);
  for (Eigen::Index i = 1; i < 5; ++i) CHECK(spectrum.values[i - 1] <= spectrum.values[i]);
}

TEST(NormalMatrix, TheSingularValuesAreTheStretchOfTheirVectors) {
  std::mt19937 random(kSeed);
  const MatrixXd matrix = Random(12, 9, random);
  const auto singular = adit::host::SingularValuesOf(matrix);
  for (Eigen::Index i = 0; i < 9; ++i)
    DOUBLES_EQUAL(singular.values[i], (matrix * singular.right.col(i)).norm(), 1e-12);
  CHECK((singular.right.transpose() * singular.right - MatrixXd::Identity(9, 9)).norm() < 1e-12);
}

TEST(NormalMatrix, TheShortestSolutionSharesBetweenColumnsThatAreAlike) {
  MatrixXd matrix(3, 3);
  matrix << 1, 1, 0, 2, 2, 0, 0, 0, 4;
  const VectorXd x = ShortestSolution(matrix, Eigen::Vector3d(6, 12, 8));
  CHECK((x - Eigen::Vector3d(3, 3, 2)).norm() < 1e-12);
}
