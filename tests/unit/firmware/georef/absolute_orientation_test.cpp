#include "firmware/georef/absolute_orientation.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>

#include <CppUTest/TestHarness.h>

using adit::georef::AbsoluteOrientation;
using adit::georef::FormatOrientation;
using adit::georef::LoadOrientation;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const char* const kPath = "absolute_orientation_test.tmp.yaml";

AbsoluteOrientation Example() {
  AbsoluteOrientation orientation;
  orientation.T_s_b.rotation = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  orientation.T_s_b.translation_m = {2600000.123, 1200000.456, 431.789};
  orientation.grid_scale_factor = 0.9996;
  orientation.reference_b_m = {0.1, -0.2, 40};
  const Eigen::Matrix<double, 6, 6> root =
      Eigen::Matrix<double, 6, 6>::NullaryExpr([](Eigen::Index r, Eigen::Index c) {
        return 1e-3 * std::sin(1.0 + 7.0 * static_cast<double>(r) + 3.0 * static_cast<double>(c * c));
      });
  orientation.covariance = root * root.transpose();
  orientation.calibration_id = "1a2b3c4d";
  return orientation;
}

/// What LoadOrientation says of the example with `from` replaced by `to`.
std::string Complaint(const std::string& from, const std::string& to, int parameters = 6) {
  std::string text = FormatOrientation(Example(), parameters, 1);
  if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
  std::ofstream(kPath) << text;
  const auto loaded = LoadOrientation(kPath, "1a2b3c4d");
  return loaded ? "" : loaded.error().Line();
}

}  // namespace

TEST_GROUP(AbsoluteOrientation){void teardown() override{std::remove(kPath);
}
}
;

TEST(AbsoluteOrientation, ReadsBackTheSameBits) {
  const AbsoluteOrientation written = Example();
  std::ofstream(kPath) << FormatOrientation(written, 6, 1);
  const auto read = LoadOrientation(kPath, "1a2b3c4d");
  CHECK_TRUE(!!read);
  CHECK_TRUE(read->T_s_b.rotation == written.T_s_b.rotation);
  CHECK_TRUE(read->T_s_b.translation_m == written.T_s_b.translation_m);
  CHECK_TRUE(read->reference_b_m == written.reference_b_m);
  CHECK_TRUE(read->covariance == written.covariance);
  DOUBLES_EQUAL(written.grid_scale_factor, read->grid_scale_factor, 0);
}

TEST(AbsoluteOrientation, NamesFileKeyAndWhatIsAllowed) {
  STRCMP_EQUAL("", Complaint("", "").c_str());
  STRCMP_CONTAINS("absolute_orientation_test.tmp.yaml: T_s_b",
                  Complaint("[0, 0, 0, 1]", "[0, 0, 1, 1]").c_str());
  STRCMP_CONTAINS("grid_scale_factor: is '2'", Complaint("0.99960000000000004", "2").c_str());
  STRCMP_CONTAINS("parameters: is 5; it must be 4 or 6", Complaint("parameters: 6", "parameters: 5").c_str());
  STRCMP_CONTAINS("scale: must be 1", Complaint("\nscale: 1", "\nscale: 1.001").c_str());
  STRCMP_CONTAINS("is missing", Complaint("reference_b_m", "#").c_str());
  STRCMP_CONTAINS("shift", Complaint("parameters", "shift: 1\nparameters").c_str());
}

TEST(AbsoluteOrientation, RefusesTheRigFrameOfAnotherCalibration) {
  const std::string complaint = Complaint("1a2b3c4d", "99999999");
  STRCMP_CONTAINS("calibration_id", complaint.c_str());
  STRCMP_CONTAINS("'1a2b3c4d'", complaint.c_str());
}

TEST(AbsoluteOrientation, RefusesSevenParametersToSteerBy) {
  STRCMP_CONTAINS("parameters: is 7", Complaint("", "", 7).c_str());
}

TEST(AbsoluteOrientation, RefusesACovarianceThatIsNone) {
  AbsoluteOrientation skewed = Example();
  skewed.covariance(0, 1) += 1e-4;
  std::ofstream(kPath) << FormatOrientation(skewed, 6, 1);
  STRCMP_CONTAINS("covariance: is not symmetric", LoadOrientation(kPath, "1a2b3c4d").error().Line().c_str());
  AbsoluteOrientation negative = Example();
  negative.covariance(4, 4) = -1e-4;
  std::ofstream(kPath) << FormatOrientation(negative, 6, 1);
  STRCMP_CONTAINS("negative variance", LoadOrientation(kPath, "1a2b3c4d").error().Line().c_str());
}

TEST(AbsoluteOrientation, PropagatesWhatRandomDrawsShow) {
  constexpr unsigned kSeed = 20;
  std::printf("seed %u ", kSeed);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  const AbsoluteOrientation mean = Example();
  const Eigen::Matrix<double, 6, 6> root = mean.covariance.llt().matrixL();
  const Vector3d point_b_m(3, -2, 60), sigma_b_m(0.001, 0.002, 0.005);
  const Vector3d place_s_m = mean.Apply(point_b_m);
  constexpr int kDraws = 20000;
  Matrix3d squares = Matrix3d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::Matrix<double, 6, 1> unit;
    for (int i = 0; i < 6; ++i) unit[i] = normal(random);
    const Eigen::Matrix<double, 6, 1> error = root * unit;
    const Vector3d turn_rad = error.head<3>();
    // Written out apart from the code under test: turn about the reference point, then shift.
    const Matrix3d turned = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()) * mean.T_s_b.rotation;
    const Vector3d noisy_b_m =
        point_b_m + sigma_b_m.cwiseProduct(Vector3d(normal(random), normal(random), normal(random)));
    const Vector3d k(mean.grid_scale_factor, mean.grid_scale_factor, 1);
    const Vector3d drawn_s_m = mean.Apply(mean.reference_b_m) + Vector3d(error.tail<3>()) +
                               k.cwiseProduct(Vector3d(turned * (noisy_b_m - mean.reference_b_m)));
    squares += (drawn_s_m - place_s_m) * (drawn_s_m - place_s_m).transpose() / kDraws;
  }
  const Matrix3d told = mean.Propagate(point_b_m, Vector3d(sigma_b_m.cwiseAbs2()).asDiagonal());
  CHECK((squares - told).norm() < 0.03 * told.norm());  // 20000 draws: 1 % of a variance is one sigma
}
