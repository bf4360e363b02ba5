#include "firmware/georef/attitude.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/support/frames_page.h"

#include <CppUTest/TestHarness.h>

using adit::georef::AttitudeOf;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kPi = std::numbers::pi;

/// The header's product, turn by turn.
Matrix3d RotationOf(double heading_rad, double pitch_rad, double roll_rad) {
  return (AngleAxisd(kPi / 2 - heading_rad, Vector3d::UnitZ()) * AngleAxisd(-pitch_rad, Vector3d::UnitY()) *
          AngleAxisd(roll_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace

TEST_GROUP(Attitude){};

TEST(Attitude, IsThatOfTheFramesPage) {
  const auto page = adit::tests::ReadFramesPage();
  Matrix3d R_s_t;
  for (int r = 0; r < 3; ++r) {
    const auto& row = page.at("T_s_body_row" + std::to_string(r));
    R_s_t.row(r) = Vector3d(row[0], row[1], row[2]);
  }
  const auto attitude = AttitudeOf(R_s_t);
  CHECK(attitude.has_value());
  const auto& expected_deg = page.at("attitude_deg");
  DOUBLES_EQUAL(expected_deg[0], attitude->heading_rad * 180 / kPi, 5e-7);
  DOUBLES_EQUAL(expected_deg[1], attitude->pitch_rad * 180 / kPi, 5e-7);
  DOUBLES_EQUAL(expected_deg[2], attitude->roll_rad * 180 / kPi, 5e-7);
}

TEST(Attitude, UndoesItsOwnTurnsSeed1) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    const auto uniform = [&random](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double heading_rad = uniform(0, 2 * kPi), pitch_rad = uniform(-1.5, 1.5),
                 roll_rad = uniform(-kPi, kPi);
    const auto attitude = AttitudeOf(RotationOf(heading_rad, pitch_rad, roll_rad));
    CHECK(attitude.has_value());
    DOUBLES_EQUAL(heading_rad, attitude->heading_rad, 1e-9);
    DOUBLES_EQUAL(pitch_rad, attitude->pitch_rad, 1e-9);
    DOUBLES_EQUAL(roll_rad, attitude->roll_rad, 1e-9);
  }
}

TEST(Attitude, CountsHeadingsClockwiseFromNorth) {
  const std::array<double, 4> headings_deg{0, 90, 180, 270};
  const std::array<Vector3d, 4> ways{Vector3d(0, 1, 0), Vector3d(1, 0, 0), Vector3d(0, -1, 0),
                                     Vector3d(-1, 0, 0)};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    Matrix3d R_s_t;
    R_s_t << ways[i], Vector3d::UnitZ().cross(ways[i]), Vector3d::UnitZ();
    DOUBLES_EQUAL(headings_deg[i], AttitudeOf(R_s_t)->heading_rad * 180 / kPi, 1e-9);
  }
}

TEST(Attitude, HasNoneForABodyThatStandsUprightOrIsNoRotation) {
  CHECK_FALSE(AttitudeOf(RotationOf(1, kPi / 2, 0)).has_value());
  CHECK_FALSE(AttitudeOf(RotationOf(1, -kPi / 2 + 0.01, 0)).has_value());
  CHECK_FALSE(AttitudeOf(Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())).has_value());
}
