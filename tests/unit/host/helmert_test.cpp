#include "host/helmert.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "tests/unit/host/published_fits.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CommonPoint;
using adit::host::FitHelmert;
using adit::host::Helmert;
using adit::host::HelmertOptions;
using adit::test::PublishedFit;
using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<CommonPoint> Unweighted(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  std::vector<CommonPoint> points(from.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].rig_b_m = from[i];
    points[i].control_s_m = to[i];
  }
  return points;
}

void CheckFit(const PublishedFit& published) {
  const auto points = Unweighted(published.from, published.to);
  HelmertOptions options;
  options.estimate_scale = published.estimates_scale;
  const auto fit = FitHelmert(points, options);
  CHECK_TEXT(!!fit, published.name);
  // Thirteen digits are what coordinates of four million metres leave of a scale.
  DOUBLES_EQUAL_TEXT(published.scale, fit->scale, 1e-13 * 10, published.name);
  CHECK_TEXT((fit->R_s_b - published.rotation).cwiseAbs().maxCoeff() < 1e-12, published.name);
  CHECK_TEXT((fit->Apply(Vector3d::Zero()) - published.translation).cwiseAbs().maxCoeff() < 5e-6,
             published.name);
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d residual = fit->Residual(points[i]);
    CHECK_TEXT((residual - published.residuals[i]).cwiseAbs().maxCoeff() <= 0.5001e-5, published.name);
    squares += residual.squaredNorm();
  }
  DOUBLES_EQUAL_TEXT(published.rms_component, std::sqrt(squares / static_cast<double>(3 * points.size())),
                     1e-9 * published.rms_component, published.name);
}

/// What FitHelmert says when it declines.
std::string Complaint(const std::vector<CommonPoint>& points, const HelmertOptions& options = {}) {
  const auto fit = FitHelmert(points, options);
  return fit ? "" : fit.error().Line();
}

/// The points of `from` seen from a rig that looks along azimuth 30 degrees; 2 mm of control, 1 mm of rig.
std::vector<CommonPoint> Surveyed(const std::vector<Vector3d>& from, double grid_scale_factor = 1) {
  Matrix3d R_s_b;
  R_s_b << std::sqrt(0.75), 0, 0.5, -0.5, 0, std::sqrt(0.75), 0, -1, 0;
  std::vector<Vector3d> to;
  for (const Vector3d& point : from) {
    const Vector3d turned = R_s_b * point;
    to.emplace_back(2600100 + grid_scale_factor * turned.x(), 1200200 + grid_scale_factor * turned.y(),
                    430 + turned.z());
  }
  auto points = Unweighted(from, to);
  for (CommonPoint& point : points) {
    point.control_covariance_m2 = 4e-6 * Matrix3d::Identity();
    point.rig_covariance_m2 = 1e-6 * Matrix3d::Identity();
  }
  return points;
}

const std::vector<Vector3d> kSpread{{-5, 1, 30}, {6, -2, 40}, {2, 3, 55}, {-4, -3, 45}};

}  // namespace

TEST_GROUP(Helmert){};

TEST(Helmert, ReproducesPublishedSevenAndSixParameterFits) {
  for (const auto& fits :
       {adit::test::GrafarendAwange(), adit::test::GhilaniWolf(), adit::test::Coordtrans()}) {
    for (const PublishedFit& fit : fits) CheckFit(fit);
  }
}

TEST(Helmert, PrintsWhatTheTextbooksPrint) {
  HelmertOptions options;
  options.estimate_scale = true;
  const auto grafarend = adit::test::GrafarendAwange()[0];
  const auto fit = *FitHelmert(Unweighted(grafarend.from, grafarend.to), options);
  DOUBLES_EQUAL(1.00000558252, fit.scale, 0.5e-11);
  CHECK((fit.Apply(Vector3d::Zero()) - Vector3d(641.8804, 68.6553, 416.3982)).cwiseAbs().maxCoeff() <=
        0.51e-4);
  const auto ghilani = adit::test::GhilaniWolf()[0];
  const auto large = *FitHelmert(Unweighted(ghilani.from, ghilani.to), options);
  DOUBLES_EQUAL(0.94995694, large.scale, 0.5e-8);
  CHECK((large.Apply(Vector3d::Zero()) - Vector3d(10233.826, 6549.968, 720.879)).cwiseAbs().maxCoeff() <=
        0.51e-3);
}

TEST(Helmert, FitsInPlanWhatGeoEasyFits) {
  // GeoEasy's sample test1.geo into test_trafo.coo (easting, northing): its orthogonal transformation has an
  // RMS of 0.008.
  const std::vector<Vector3d> from{{91515.44, 2815.22, 0}, {90661.58, 1475.28, 0}, {84862.54, 3865.36, 0},
                                   {91164.16, 4415.08, 0}, {86808.18, 347.66, 0},  {90050.24, 3525.12, 0}};
  const std::vector<Vector3d> to{{653199.72, 249226.07, 0}, {652345.850, 247886.15, 0},
                                 {646546.83, 250276.24, 0}, {652848.44, 250825.94, 0},
                                 {648492.46, 246758.54, 0}, {651734.51, 249935.97, 0}};
  HelmertOptions options;
  options.estimate_tilt = false;
  options.estimate_scale = true;
  options.R_level_b.setIdentity();
  const auto points = Unweighted(from, to);
  const auto fit = *FitHelmert(points, options);
  double squares = 0;
  for (const CommonPoint& point : points) squares += fit.Residual(point).squaredNorm();
  DOUBLES_EQUAL(0.008, std::sqrt(squares / 6), 0.0005);
}

TEST(Helmert, AppliesAsProjDoes) {
  // PROJ's self-test of +proj=helmert +exact, coordinate frame convention.
  constexpr double kRadPerArcsecond = 3.14159265358979323846 / 180 / 3600;
  const Vector3d turn = kRadPerArcsecond * Vector3d(-0.48488, -0.02436, -0.41321);
  Helmert helmert;
  helmert.R_s_b =
      (Eigen::AngleAxisd(-turn.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(-turn.y(), Vector3d::UnitY()) *
       Eigen::AngleAxisd(-turn.x(), Vector3d::UnitX()))
          .toRotationMatrix();
  helmert.scale = 1 - 0.540645e-6;
  helmert.reference_s_m = {-81.0703, -89.3603, -115.7526};
  const Vector3d there = helmert.Apply({3494994.3012, 1056601.9725, 5212382.1666});
  CHECK((there - Vector3d(3494909.84026368, 1056506.78938633, 5212265.66699761)).norm() < 1e-7);
}

TEST(Helmert, TakesTheGridScaleFromThePlaneOnly) {
  HelmertOptions options;
  options.grid_scale_factor = 0.9996;
  const auto points = Surveyed(kSpread, 0.9996);
  const auto fit = *FitHelmert(points, options);
  for (const CommonPoint& point : points) CHECK(fit.Residual(point).norm() < 1e-8);
  DOUBLES_EQUAL(0, fit.sigma0, 1e-5);
  LONGS_EQUAL(6, fit.redundancy);
  // Not given, it stays in the residuals: 40 mm in 100 m.
  CHECK((*FitHelmert(points, {})).sigma0 > 0.5);
}

TEST(Helmert, LeavesALevelledRigLevel) {
  HelmertOptions options;
  options.estimate_tilt = false;
  auto points = Surveyed({kSpread[0], kSpread[1]});
  points[1].control_s_m.z() += 0.004;
  const auto fit = *FitHelmert(points, options);
  CHECK((fit.R_s_b.row(2) - Eigen::RowVector3d(0, -1, 0)).norm() < 1e-12);
  DOUBLES_EQUAL(0.002, fit.Residual(points[1]).z(), 1e-8);
  const Eigen::Matrix2d tilt = fit.covariance.topLeftCorner<2, 2>();
  CHECK(tilt.isZero());
  LONGS_EQUAL(2, fit.redundancy);
}

TEST(Helmert, WeighsByBothMeasurements) {
  auto points = Surveyed(kSpread);
  points[3].control_covariance_m2 *= 1e8;  // twenty metres
  points[3].control_s_m += Vector3d(1, 2, 3);
  const auto fit = *FitHelmert(points, {});
  for (std::size_t i = 0; i < 3; ++i) CHECK(fit.Residual(points[i]).norm() < 1e-6);
  CHECK(fit.Residual(points[3]).isApprox(Vector3d(1, 2, 3), 1e-6));
}

TEST(Helmert, RefusesTooFewPoints) {
  const auto points = Surveyed({kSpread[0], kSpread[1]});
  STRCMP_CONTAINS("2 common points; 6 parameters need at least 3", Complaint(points).c_str());
  HelmertOptions level;
  level.estimate_tilt = false;
  STRCMP_CONTAINS("1 common points; 4 parameters need at least 2", Complaint({points[0]}, level).c_str());
}

TEST(Helmert, RefusesPointsOnOneLine) {
  auto points = Surveyed({{0, 0, 30}, {1, 0.5, 35}, {2, 1, 40}, {3, 1.5, 45}});
  STRCMP_CONTAINS("lie on one line", Complaint(points).c_str());
  points[1].rig_b_m.x() += 0.02;  // off the line by some sigmas only
  STRCMP_CONTAINS("mrad", Complaint(points).c_str());
}

TEST(Helmert, RefusesPointsAboveEachOtherWithoutTilt) {
  HelmertOptions options;
  options.estimate_tilt = false;
  STRCMP_CONTAINS("one place in plan", Complaint(Surveyed({{0, -3, 30}, {0, 3, 30}}), options).c_str());
}

// A coordinate that was left at zero is megametres off: too far for the adjustment to find its place.
TEST(Helmert, NamesThePointThatKeepsItFromConverging) {
  auto points = Surveyed({{-3, 1, 20}, {3, -1, 30}, {2, -2, 45}, {-1, 2, 60}, {3, 1, 70}});
  for (std::size_t i = 0; i < points.size(); ++i) points[i].name = "P" + std::to_string(i + 1);
  for (std::size_t wrong = 0; wrong < points.size(); ++wrong) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      auto mistaken = points;
      mistaken[wrong].control_s_m[axis] = 0;
      const std::string complaint = Complaint(mistaken);
      STRCMP_CONTAINS(("point " + points[wrong].name + " is").c_str(), complaint.c_str());
    }
  }
}

TEST(Helmert, ItsJacobianIsThatOfDifferences) {
  auto points = Surveyed(kSpread, 0.9996);
  HelmertOptions options;
  options.estimate_scale = true;
  options.grid_scale_factor = 0.9996;
  const Helmert fit = *FitHelmert(points, options);
  const Vector3d point(3, -7, 80);
  const auto jacobian = fit.Jacobian(point);
  constexpr double kStep = 1e-5;
  for (int parameter = 0; parameter < 7; ++parameter) {
    std::array<Vector3d, 2> moved;
    for (const int side : {0, 1}) {
      Helmert other = fit;
      const double step = side == 0 ? -kStep : kStep;
      if (parameter < 3) other.R_s_b = Eigen::AngleAxisd(step, Vector3d::Unit(parameter)) * fit.R_s_b;
      if (parameter >= 3 && parameter < 6) other.reference_s_m[parameter - 3] += step;
      if (parameter == 6) other.scale += step;
      moved[static_cast<std::size_t>(side)] = other.Apply(point);
    }
    CHECK((jacobian.col(parameter) - (moved[1] - moved[0]) / (2 * kStep)).norm() < 1e-4);
  }
}
