#include "host/rig_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "host/simulated_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Gauss;
using adit::host::Predict;
using adit::host::RawPair;
using adit::host::TrueRig;
using adit::optics::kRigParameters;
using adit::optics::RigCovariance;
using Eigen::Vector3d;
using RigStep = Eigen::Matrix<double, kRigParameters, 1>;

RawPair PairOf(const TrueRig& rig, const Vector3d& point_m) {
  const Eigen::Vector4d px = rig.Project(point_m);
  return {px.head<2>(), px.tail<2>()};
}

/// Correlated, of the size that a calibration leaves.
RigCovariance SomeCovariance(adit::sim::Random& random) {
  RigStep sigma;
  Eigen::Matrix<double, 8, 1> camera;
  camera << 0.5, 0.5, 0.6, 0.6, 5e-4, 5e-3, 3e-5, 3e-5;
  sigma << 2e-6, 30e-6, 4e-6, 7e-4, 1e-4, 4e-4, camera, camera;
  RigCovariance mixed;
  for (double& value : mixed.reshaped()) value = Gauss(random) / 5;
  const RigCovariance correlated = RigCovariance::Identity() + mixed * mixed.transpose();
  return sigma.asDiagonal() * correlated * sigma.asDiagonal();
}

/// The point that Predict means: ahead of the middle of the baseline, between both axes.
Vector3d Ahead(const TrueRig& rig, double distance_m) {
  const Vector3d right_m = -(rig.rotation.transpose() * rig.translation_m);
  return 0.5 * right_m + distance_m * (Vector3d::UnitZ() + rig.rotation.transpose().col(2)).normalized();
}

}  // namespace

TEST_GROUP(RigUncertainty){};

TEST(RigUncertainty, ATrueRigLocatesWhatItProjects) {
  const TrueRig truth = adit::host::MakeTrueRig(9, 35);
  for (const double distance_m : {15.0, 30.0, 70.0, 110.0}) {
    const Vector3d point_m = Ahead(truth, distance_m) + Vector3d(0.5, -0.3, 0);
    const auto place_m = Locate(truth.AsRig(), PairOf(truth, point_m));
    CHECK(place_m.has_value());
    DOUBLES_EQUAL(0, (*place_m - point_m).norm(), 1e-6);
  }
}

// 4000 rigs drawn from the covariance, each locating the same pixels: a standard deviation of 4000 draws is
// right within 1.1 %, 1 sigma.
TEST(RigUncertainty, PredictsWhatRigsOfItsCovarianceScatterBy) {
  adit::sim::Random random(5);
  const TrueRig truth = adit::host::MakeTrueRig(9, 35);
  const RigCovariance covariance = SomeCovariance(random);
  const RigCovariance root = covariance.llt().matrixL();
  for (const double distance_m : {30.0, 70.0, 110.0}) {
    const RawPair pair = PairOf(truth, Ahead(truth, distance_m));
    constexpr int kDraws = 4000;
    Vector3d sum = Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (int i = 0; i < kDraws; ++i) {
      RigStep z;
      for (double& value : z) value = Gauss(random);
      const auto place_m = Locate(truth.Moved(root * z).AsRig(), pair);
      CHECK(place_m.has_value());
      const Vector3d error_m = *place_m - Ahead(truth, distance_m);
      sum += error_m, squares += error_m * error_m.transpose();
    }
    const Eigen::Matrix3d scatter = squares / kDraws - sum * sum.transpose() / (kDraws * kDraws);
    const Vector3d along =
        (Ahead(truth, distance_m) - Ahead(truth, 0)).normalized();  // Ahead(0): the middle of the baseline
    const Vector3d across = Vector3d::UnitY().cross(along).normalized(), up = along.cross(across);
    const auto predicted = Predict(truth.AsRig(), covariance, distance_m, 0.01);
    CHECK(predicted.has_value());
    DOUBLES_EQUAL(distance_m, predicted->distance_m, 1e-6);
    const auto sigma_m = [&](const Vector3d& axis) { return std::sqrt(axis.dot(scatter * axis)); };
    DOUBLES_EQUAL(1, predicted->across_m / sigma_m(across), 0.04);
    DOUBLES_EQUAL(1, predicted->up_m / sigma_m(up), 0.04);
    DOUBLES_EQUAL(1, predicted->depth_m / sigma_m(along), 0.04);
  }
}

// Depth z = f B / d of parallel cameras: dz/dd = z^2 / (f B), dz/dyaw = z^2 / B.
TEST(RigUncertainty, SensitivitiesOfParallelCamerasAreTheTextbooks) {
  TrueRig rig = adit::host::MakeTrueRig(3, 1e9);
  rig.rotation.setIdentity();
  rig.translation_m = {-3, 0, 0};
  for (const double distance_m : {30.0, 70.0, 110.0}) {
    const auto predicted = Predict(rig.AsRig(), RigCovariance::Zero(), distance_m, 0.01);
    CHECK(predicted.has_value());
    const double z2 = distance_m * distance_m;
    DOUBLES_EQUAL(1, predicted->depth_per_px_m / (z2 / (3378 * 3)), 0.01);
    DOUBLES_EQUAL(1, predicted->depth_per_yaw_m_rad / (z2 / 3), 0.01);
    DOUBLES_EQUAL(1, predicted->noise_depth_m / (std::sqrt(2) * 0.01 * z2 / (3378 * 3)), 0.01);
    DOUBLES_EQUAL(0, predicted->depth_m, 0);
  }
}

TEST(RigUncertainty, DeclinesAPointThatTheCamerasLookPast) {
  const TrueRig rig = adit::host::MakeTrueRig(9, 35);
  CHECK_FALSE(Predict(rig.AsRig(), RigCovariance::Zero(), 1, 0.01).has_value());
}
