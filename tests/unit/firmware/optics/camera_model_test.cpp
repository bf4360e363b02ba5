#include "firmware/optics/camera_model.h"

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using adit::optics::CameraModel;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr unsigned kCameraSeed = 31;

/// Lenses from none to a strong barrel, whose images do not fold over.
std::vector<CameraModel> Lenses() {
  const CameraModel plain{3400, 3410, 705.2, 498.7, 0, 0, 0, 0, 1400, 1024};
  CameraModel barrel = plain, cushion = plain, wide = plain, tilted = plain;
  barrel.k1 = -0.21, barrel.k2 = 0.13;
  cushion.k1 = 0.15, cushion.k2 = -0.08, cushion.p1 = 4e-4, cushion.p2 = -7e-4;
  wide.fu_px = 900, wide.fv_px = 905, wide.k1 = -0.28, wide.k2 = 0.07, wide.p1 = 2e-4, wide.p2 = 1.8e-5;
  tilted.p1 = 5e-3, tilted.p2 = -8e-3;
  return {plain, barrel, cushion, wide, tilted};
}

/// Pixels on a grid over the image and 20 px around it.
std::vector<Vector2d> Grid(const CameraModel& camera) {
  std::vector<Vector2d> grid;
  for (int i = 0; i <= 20; ++i) {
    for (int j = 0; j <= 20; ++j)
      grid.emplace_back(-20 + (camera.width_px + 40) * i / 20.0, -20 + (camera.height_px + 40) * j / 20.0);
  }
  return grid;
}

cv::Mat Matrix(const CameraModel& c) {
  return (cv::Mat_<double>(3, 3) << c.fu_px, 0, c.cu_px, 0, c.fv_px, c.cv_px, 0, 0, 1);
}

std::vector<double> Coefficients(const CameraModel& c) { return {c.k1, c.k2, c.p1, c.p2}; }

}  // namespace

TEST_GROUP(CameraModel){};

TEST(CameraModel, ProjectsAsOpenCvDoes_Seed31) {
  std::mt19937 random(kCameraSeed);
  std::uniform_real_distribution<double> slope(-0.35, 0.35), depth_m(0.5, 150);
  for (const CameraModel& camera : Lenses()) {
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 200; ++i) {
      const double z = depth_m(random);
      points.emplace_back(z * slope(random), z * slope(random), z);
    }
    std::vector<cv::Point2d> expected;
    cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), Matrix(camera), Coefficients(camera),
                      expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.Project({points[i].x, points[i].y, points[i].z});
      CHECK(pixel.has_value());
      DOUBLES_EQUAL(0, (*pixel - Vector2d(expected[i].x, expected[i].y)).norm(), 1e-9);
    }
  }
}

TEST(CameraModel, UndistortsAsOpenCvDoesAtItsBest) {
  for (const CameraModel& camera : Lenses()) {
    for (const Vector2d& raw : Grid(camera)) {
      std::vector<cv::Point2d> in{{raw.x(), raw.y()}}, expected;
      // OpenCV's fixed-point iteration needs many rounds where Newton's method needs four.
      cv::undistortPoints(in, expected, Matrix(camera), Coefficients(camera), cv::noArray(), Matrix(camera),
                          cv::TermCriteria(cv::TermCriteria::COUNT, 500, 0));
      const auto ideal = camera.Undistort(raw);
      CHECK(ideal.has_value());
      DOUBLES_EQUAL(0, (*ideal - Vector2d(expected[0].x, expected[0].y)).norm(), 1e-8);
    }
  }
}

TEST(CameraModel, ComesBackFromRawToIdealAndToRawWithinANanopixel) {
  for (const CameraModel& camera : Lenses()) {
    for (const Vector2d& raw : Grid(camera)) {
      const auto ideal = camera.Undistort(raw);
      CHECK(ideal.has_value());
      const Vector2d again = camera.Pixel(camera.Distort(camera.Normalised(*ideal)));
      DOUBLES_EQUAL(0, (again - raw).norm(), 1e-9);
    }
  }
}

TEST(CameraModel, GivesTheJacobianOfTheDistortion) {
  constexpr double kStep = 1e-6;  // normalised; central differences are good to about its square
  for (const CameraModel& camera : Lenses()) {
    for (const Vector2d& pixel : Grid(camera)) {
      const Vector2d at = camera.Normalised(pixel);
      Matrix2d jacobian, difference;
      camera.Distort(at, &jacobian);
      for (int i = 0; i < 2; ++i) {
        const Vector2d step = kStep * Vector2d::Unit(i);
        difference.col(i) = (camera.Distort(at + step) - camera.Distort(at - step)) / (2 * kStep);
      }
      DOUBLES_EQUAL(0, (jacobian - difference).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(CameraModel, GivesTheJacobianOfTheUndistortionInPixels) {
  constexpr double kStepPx = 1e-2;
  for (const CameraModel& camera : Lenses()) {
    for (const Vector2d& raw : Grid(camera)) {
      Matrix2d jacobian, difference;
      CHECK(camera.Undistort(raw, &jacobian).has_value());
      for (int i = 0; i < 2; ++i) {
        const Vector2d step = kStepPx * Vector2d::Unit(i);
        difference.col(i) = (*camera.Undistort(raw + step) - *camera.Undistort(raw - step)) / (2 * kStepPx);
      }
      DOUBLES_EQUAL(0, (jacobian - difference).cwiseAbs().maxCoeff(), 1e-7);
    }
  }
}

TEST(CameraModel, DeclinesPointsAtAndBehindTheProjectionCentre) {
  const CameraModel camera = Lenses().front();
  for (const double z : {0.0, -1.0, -1e-9, 1e-9}) CHECK_FALSE(camera.Project({0.1, 0.1, z}).has_value());
  CHECK_FALSE(camera.Project({0, 0, std::nan("")}).has_value());
  CHECK_TRUE(camera.Project({0, 0, 0.01}).has_value());
}

TEST(CameraModel, DeclinesRawPixelsThatNoRayReaches) {
  // k1 = -0.3: the distorted radius r (1 - 0.3 r^2) has its maximum 0.703 at r = 1.054; nothing is seen
  // beyond.
  CameraModel camera{1000, 1000, 0, 0, -0.3, 0, 0, 0, 2000, 2000};
  CHECK_TRUE(camera.Undistort({650, 0}).has_value());
  for (const double u : {705.0, 720.0, 800.0, 1000.0, 1500.0, 5000.0, 1e6, 1e150, 1e300}) {
    CHECK_FALSE(camera.Undistort({u, 0}).has_value());
    CHECK_FALSE(camera.Undistort({0, -u}).has_value());
    CHECK_FALSE(camera.Undistort({u, u}).has_value());
  }
  CHECK_FALSE(camera.Undistort({std::nan(""), 0}).has_value());
  CHECK_FALSE(camera.Undistort({std::numeric_limits<double>::infinity(), 0}).has_value());
}

TEST(CameraModel, NeverReturnsARayFromBeyondTheFold) {
  // With k2 > 0 the radius falls and then rises again: a second ray reaches the same pixel, and a wild Newton
  // step could find it. The first maximum, where 1 + 3 k1 s + 5 k2 s^2 = 0 with s = r^2, bounds what the lens
  // images.
  for (const double k2 : {0.02, 0.05, 0.08, 0.1}) {
    const CameraModel camera{1000, 1000, 0, 0, -0.5, k2, 0, 0, 2000, 2000};
    const double fold = std::sqrt((1.5 - std::sqrt(2.25 - 20 * k2)) / (10 * k2));
    const double fold_px = 1000 * camera.Distort({fold, 0}).x();
    for (int i = 0; i < 2000; ++i) {
      const double raw_px = i;
      const auto ideal = camera.Undistort({raw_px * 0.6, raw_px * 0.8});
      if (raw_px < 0.9 * fold_px) CHECK_TRUE(ideal.has_value());
      if (raw_px > fold_px) CHECK_FALSE(ideal.has_value());
      if (ideal) CHECK_TRUE(ideal->norm() <= 1000 * fold);
    }
  }
}

TEST(CameraModel, DeclinesToProjectRaysThatTheLensFoldsBackIntoTheImage) {
  const CameraModel camera{1000, 1000, 0, 0, -0.5, 0.08, 0, 0, 2000, 2000};
  CHECK_TRUE(camera.Project({0.9, 0, 1}).has_value());
  for (const double x : {0.94, 1.0, 1.3, 1.6, 2.0, 5.0}) CHECK_FALSE(camera.Project({x, 0, 1}).has_value());
  const CameraModel barrel{1000, 1000, 0, 0, -0.3, 0, 0, 0, 2000, 2000};
  for (const double x : {1.06, 1.5, 1.82, 1.9, 30.0}) CHECK_FALSE(barrel.Project({0, x, 1}).has_value());
}

TEST(CameraModel, GivesTheCameraMatrix) {
  const CameraModel camera = Lenses().front();
  const Vector3d pixel = camera.K() * Vector3d(0.1, -0.2, 1);
  DOUBLES_EQUAL(0, (pixel.head<2>() - camera.Pixel({0.1, -0.2})).norm(), 1e-12);
  DOUBLES_EQUAL(1, pixel.z(), 0);
  DOUBLES_EQUAL(0, (camera.Normalised(pixel.head<2>()) - Vector2d(0.1, -0.2)).norm(), 1e-15);
}
