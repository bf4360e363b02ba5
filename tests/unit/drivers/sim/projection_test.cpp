#include "drivers/sim/projection.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include <CppUTest/TestHarness.h>

using adit::optics::CameraModel;
using adit::sim::ProjectPoint;

TEST_GROUP(Projection){};

TEST(Projection, IsWhatTheFormulaGivesByHand) {
  // x = 0.1, y = 0.2, r^2 = 0.05; 1 - 0.1 * 0.05 + 0.01 * 0.0025 = 0.995025.
  // x_d = 0.0995025 + 2 * 0.001 * 0.02 - 0.002 * (0.05 + 0.02) = 0.0994025
  // y_d = 0.199005 + 0.001 * (0.05 + 0.08) - 2 * 0.002 * 0.02 = 0.199055
  const CameraModel camera{1000, 1100, 500, 400, -0.1, 0.01, 0.001, -0.002, 1000, 800};
  const auto px = ProjectPoint(camera, {1, 2, 10});
  DOUBLES_EQUAL(500 + 99.4025, px->x(), 1e-9);
  DOUBLES_EQUAL(400 + 1100 * 0.199055, px->y(), 1e-9);
}

TEST(Projection, IsThatOfOpenCv) {
  const CameraModel camera{3378, 3380, 704.2, 508.9, -0.102, 0.11, 0.0003, -0.0002, 1400, 1024};
  const cv::Matx33d k(3378, 0, 704.2, 0, 3380, 508.9, 0, 0, 1);
  const std::vector<double> distortion{-0.102, 0.11, 0.0003, -0.0002};
  std::vector<cv::Point3d> points;
  for (int i = -5; i <= 5; ++i)
    for (int j = -5; j <= 5; ++j) points.emplace_back(0.05 * i * (30 + j), 0.03 * j * (30 + j), 30 + j);
  std::vector<cv::Point2d> expected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k, distortion, expected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto px = ProjectPoint(camera, {points[i].x, points[i].y, points[i].z});
    DOUBLES_EQUAL(expected[i].x, px->x(), 1e-9);
    DOUBLES_EQUAL(expected[i].y, px->y(), 1e-9);
  }
}

TEST(Projection, DeclinesWhatIsBehindOrAtTheCamera) {
  const CameraModel camera{1000, 1000, 500, 400, 0, 0, 0, 0, 1000, 800};
  CHECK_FALSE(ProjectPoint(camera, {0.1, 0.1, -5}).has_value());
  CHECK_FALSE(ProjectPoint(camera, {0, 0, 0}).has_value());
}

TEST(Projection, DeclinesAnglesThatTheRadialPolynomialFoldsBack) {
  // r (1 - 0.1 r^2) rises up to r = sqrt(1 / 0.3) = 1.826; at r = sqrt(10) it is 0 again: the centre.
  const CameraModel barrel{1000, 1000, 500, 400, -0.1, 0, 0, 0, 1000, 800};
  CHECK_TRUE(ProjectPoint(barrel, {1.8, 0, 1}).has_value());
  CHECK_FALSE(ProjectPoint(barrel, {1.9, 0, 1}).has_value());
  CHECK_FALSE(ProjectPoint(barrel, {3.16, 0, 1}).has_value());
  // 1 - 1.5 s + 0.5 s^2 < 0 from s = 1 to s = 2, and rises again beyond: still folded.
  const CameraModel wavy{1000, 1000, 500, 400, -0.5, 0.1, 0, 0, 1000, 800};
  CHECK_TRUE(ProjectPoint(wavy, {0.9, 0, 1}).has_value());
  CHECK_FALSE(ProjectPoint(wavy, {1.2, 0, 1}).has_value());
  CHECK_FALSE(ProjectPoint(wavy, {1.9, 0, 1}).has_value());
}
