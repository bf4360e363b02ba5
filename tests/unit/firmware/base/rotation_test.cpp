#include "firmware/base/rotation.h"

#include <Eigen/Geometry>

#include <CppUTest/TestHarness.h>

using adit::base::NearestRotation;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST_GROUP(Rotation){};

TEST(Rotation, IsFoundFromVectorsAndWhereItTakesThem) {
  const Matrix3d turn = Eigen::AngleAxisd(2.5, Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  const Vector3d vectors[] = {{1, 0, 0}, {0.5, 2, 0}, {-1, 1, 3}};
  Matrix3d sum = Matrix3d::Zero();
  for (const Vector3d& v : vectors) sum += turn * v * v.transpose();
  CHECK((NearestRotation(sum) - turn).norm() < 1e-12);
  // Two vectors span a plane, which is enough.
  sum -= turn * vectors[2] * vectors[2].transpose();
  CHECK((NearestRotation(sum) - turn).norm() < 1e-12);
}

TEST(Rotation, IsNoMirrorWhereAMirrorFitsBetter) {
  const Matrix3d mirror = Vector3d(3, 2, -1).asDiagonal();
  const Matrix3d turn = NearestRotation(mirror);
  // The least of the three is given up.
  CHECK((turn - Matrix3d::Identity()).norm() < 1e-12);
}
