#include "host/intrinsic_prior.h"

#include <Eigen/Core>
#include <string>

#include "drivers/sim/projection.h"
#include "host/simulated_calibration.h"
#include "tests/support/scratch_folder.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Gauss;
using adit::host::IntrinsicMatrix;
using adit::host::IntrinsicPrior;
using adit::host::Intrinsics;
using adit::host::IntrinsicVector;
using adit::host::kIntrinsics;
using adit::host::LoadPrior;
using adit::host::PriorOf;

adit::optics::CameraModel Camera() { return adit::host::MakeTrueRig(9, 35).AsRig().left; }

/// Correlated, with variances as different as pixels and k2.
IntrinsicMatrix SomeCovariance(std::uint64_t seed) {
  adit::sim::Random random(seed);
  IntrinsicVector sigma;
  sigma << 0.8, 0.9, 0.5, 0.6, 4e-4, 6e-3, 3e-5, 2e-5;
  IntrinsicMatrix mixed;
  for (double& value : mixed.reshaped()) value = Gauss(random) / 3;
  return sigma.asDiagonal() * (IntrinsicMatrix::Identity() + mixed * mixed.transpose()) * sigma.asDiagonal();
}

/// In units of both standard deviations; rows that are exact must be so.
void CheckEqual(const IntrinsicMatrix& expected, const IntrinsicMatrix& actual, double tolerance) {
  for (int i = 0; i < kIntrinsics; ++i) {
    for (int j = 0; j < kIntrinsics; ++j)
      DOUBLES_EQUAL(expected(i, j), actual(i, j), tolerance * std::sqrt(expected(i, i) * expected(j, j)));
  }
}

std::string CameraFile(const std::string& covariance) {
  return "camera_model: pinhole\nintrinsics: [3378, 3378, 704.2, 508.9]\ndistortion_model: "
         "radial-tangential\ndistortion_coefficients: [-0.102, 0.11, 0.0003, -0.0002]\nresolution: [1400, "
         "1024]\n" +
         covariance;
}

std::string CovarianceText(const IntrinsicMatrix& covariance) {
  std::ostringstream text;
  text.precision(9);
  text << "covariance:\n";
  for (const auto& row : covariance.rowwise()) {
    const char* between = "  - [";
    for (const double value : row) text << std::exchange(between, ", ") << value;
    text << "]\n";
  }
  return text.str();
}

}  // namespace

TEST_GROUP(IntrinsicPrior) { adit::tests::ScratchFolder folder_; };

TEST(IntrinsicPrior, SigmasAreWhatTheySay) {
  const auto camera = Camera();
  const IntrinsicMatrix covariance = PriorOf(adit::host::IntrinsicSigmas{0.05, 1, 0.2}, camera).Covariance();
  DOUBLES_EQUAL(3378 * 0.0005, std::sqrt(covariance(0, 0)), 1e-9);
  DOUBLES_EQUAL(covariance(0, 0), covariance(0, 1), 1e-9);  // fu and fv together
  DOUBLES_EQUAL(1, std::sqrt(covariance(2, 2)), 1e-12);
  DOUBLES_EQUAL(0, covariance(2, 3), 1e-12);
  // The corner farthest from the principal point, by the simulator's lens.
  auto other = camera;
  other.k1 += std::sqrt(covariance(4, 4));
  const Eigen::Vector3d corner((0 - camera.cu_px) / camera.fu_px, (1024 - camera.cv_px) / camera.fv_px, 1);
  const auto before = adit::sim::ProjectPoint(camera, corner), after = adit::sim::ProjectPoint(other, corner);
  DOUBLES_EQUAL(0.2, (*after - *before).norm(), 1e-6);
}

TEST(IntrinsicPrior, RootOfACovarianceGivesItBack) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const IntrinsicMatrix covariance = SomeCovariance(seed);
    CheckEqual(covariance, PriorOf(covariance).Covariance(), 1e-12);
  }
}

TEST(IntrinsicPrior, WhatIsKnownExactlyStaysSo) {
  IntrinsicMatrix covariance = SomeCovariance(31);
  covariance.row(5).setZero(), covariance.col(5).setZero();
  const IntrinsicPrior prior = PriorOf(covariance);
  CheckEqual(covariance, prior.Covariance(), 1e-12);
  CHECK(prior.root.row(5).isZero(0));
  CHECK_FALSE(prior.IsExact());
  CHECK(PriorOf(IntrinsicMatrix(IntrinsicMatrix::Zero())).IsExact());
}

TEST(IntrinsicPrior, StepsAreThoseThatWereTaken) {
  adit::sim::Random random(41);
  const IntrinsicVector mean = Intrinsics(Camera());
  const IntrinsicPrior whole = PriorOf(SomeCovariance(42)),
                       few = PriorOf(adit::host::IntrinsicSigmas{}, Camera());
  for (int i = 0; i < 50; ++i) {
    IntrinsicVector z;
    for (double& value : z) value = Gauss(random);
    DOUBLES_EQUAL(0, (whole.Steps(mean, mean + whole.root * z) - z).norm(), 1e-6);
    // Of the free directions only: what cannot move takes no step.
    const IntrinsicVector steps = few.Steps(mean, mean + few.root * z);
    for (int k = 0; k < kIntrinsics; ++k) DOUBLES_EQUAL(few.root.col(k).isZero(0) ? 0 : z[k], steps[k], 1e-6);
  }
}

TEST(IntrinsicPrior, ComesFromTheFileThatStatesItsCovariance) {
  const IntrinsicMatrix covariance = SomeCovariance(51);
  const auto measured =
      LoadPrior(folder_.Write("cam0.yaml", CameraFile(CovarianceText(covariance))), {}, Camera());
  const auto assumed = LoadPrior(folder_.Write("cam1.yaml", CameraFile("")), {}, Camera());
  CHECK_TRUE(measured);
  CHECK(measured->is_measured);
  CheckEqual(covariance, measured->Covariance(), 1e-7);
  CHECK_TRUE(assumed);
  CHECK_FALSE(assumed->is_measured);
  CheckEqual(PriorOf(adit::host::IntrinsicSigmas{}, Camera()).Covariance(), assumed->Covariance(), 1e-12);
}

TEST(IntrinsicPrior, RefusesWhatIsNoCovariance) {
  IntrinsicMatrix skew = SomeCovariance(61), negative = SomeCovariance(62), impossible = SomeCovariance(63);
  skew(0, 1) *= 1.5;
  negative(3, 3) *= -1;
  impossible(2, 3) = impossible(3, 2) = 3 * std::sqrt(impossible(2, 2) * impossible(3, 3));
  for (const IntrinsicMatrix& covariance : {skew, negative, impossible}) {
    const auto prior =
        LoadPrior(folder_.Write("cam0.yaml", CameraFile(CovarianceText(covariance))), {}, Camera());
    CHECK_FALSE(prior);
    STRCMP_CONTAINS("cam0.yaml", prior.error().Line().c_str());
    STRCMP_CONTAINS("covariance", prior.error().Line().c_str());
  }
  const auto half = LoadPrior(folder_.Write("cam0.yaml", CameraFile("covariance:\n  - [1, 2]\n  - [3, 4]\n")),
                              {}, Camera());
  CHECK_FALSE(half);
}
