#include "firmware/stereo/levenberg_marquardt.h"

#include <cmath>

#include <CppUTest/TestHarness.h>

using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

/// Rosenbrock's valley as two residuals; minimum 0 at (1, 1).
struct Valley {
  static constexpr int kParameters = 2, kResiduals = 2;
  using State = Vector2d;
  bool Evaluate(const Vector2d& x, Vector2d& r, Matrix2d& jacobian) const {
    r = {10 * (x.y() - x.x() * x.x()), 1 - x.x()};
    jacobian << -20 * x.x(), 10, -1, 0;
    return true;
  }
  Vector2d Moved(const Vector2d& x, const Vector2d& step) const { return x + step; }
};

/// Fits a line y = a + b x to five points of unit variance.
struct Line {
  static constexpr int kParameters = 2, kResiduals = 5;
  using State = Vector2d;
  bool Evaluate(const Vector2d& x, Eigen::Matrix<double, 5, 1>& r,
                Eigen::Matrix<double, 5, 2>& jacobian) const {
    const Eigen::Matrix<double, 5, 1> y(1.1, 2.9, 5.2, 6.8, 9.0);
    for (int i = 0; i < 5; ++i) {
      r[i] = x[0] + x[1] * i - y[i];
      jacobian.row(i) << 1, i;
    }
    return true;
  }
  Vector2d Moved(const Vector2d& x, const Vector2d& step) const { return x + step; }
};

/// A parameter that a residual of one standard deviation measures, and that another, large one bends away
/// from: the sum's second derivative at its minimum, x = 0, is `ratio` times what J^T J says.
struct Bend {
  static constexpr int kParameters = 1, kResiduals = 2;
  using State = double;
  double ratio;
  bool Evaluate(double x, Vector2d& r, Vector2d& jacobian) const {
    r = {x, kMiss + 0.5 * (ratio - 1) / kMiss * x * x};
    jacobian = {1, (ratio - 1) / kMiss * x};
    return true;
  }
  double Moved(double x, const Eigen::Matrix<double, 1, 1>& step) const { return x + step[0]; }
  static constexpr double kMiss = 6;
};

/// Has no value left of 0, and falls towards it.
struct Cliff {
  static constexpr int kParameters = 1, kResiduals = 1;
  using State = double;
  using One = Eigen::Matrix<double, 1, 1>;
  bool Evaluate(double x, One& r, One& jacobian) const {
    if (!(x > 0)) return false;
    r[0] = 1000 * (1 + x), jacobian(0, 0) = 1000;
    return true;
  }
  double Moved(double x, const One& step) const { return x + step[0]; }
};

}  // namespace

TEST_GROUP(LevenbergMarquardt){};

TEST(LevenbergMarquardt, WalksACurvedValleyToItsEnd) {
  Vector2d x(-1.2, 1);
  const auto minimum = adit::stereo::Minimise(Valley{}, x);
  CHECK(minimum.converged);
  DOUBLES_EQUAL(1, x.x(), 1e-6);
  DOUBLES_EQUAL(1, x.y(), 1e-6);
}

TEST(LevenbergMarquardt, GivesTheNormalMatrixOfALinearFit) {
  Vector2d x(0, 0);
  const auto minimum = adit::stereo::Minimise(Line{}, x);
  CHECK(minimum.converged);
  DOUBLES_EQUAL(1.06, x[0], 1e-9);  // by the textbook's formulas
  DOUBLES_EQUAL(1.97, x[1], 1e-9);
  DOUBLES_EQUAL(5, minimum.information(0, 0), 1e-9);
  DOUBLES_EQUAL(10, minimum.information(0, 1), 1e-9);
  DOUBLES_EQUAL(30, minimum.information(1, 1), 1e-9);
}

TEST(LevenbergMarquardt, ArrivesWhereLargeResidualsBendTheSum) {
  for (double ratio = 1; ratio < 100; ratio *= 1.1) {
    for (const double start : {0.3, 1.0, 3.0}) {
      double x = start;
      CHECK(adit::stereo::Minimise(Bend{ratio}, x).converged);
      DOUBLES_EQUAL(0, x, 1e-3);  // of a standard deviation
    }
  }
}

TEST(LevenbergMarquardt, DeclinesWhereThereIsNoMinimum) {
  double x = 1;
  CHECK_FALSE(adit::stereo::Minimise(Cliff{}, x).converged);
  double outside = -1;
  CHECK_FALSE(adit::stereo::Minimise(Cliff{}, outside).converged);
}
