#include "firmware/publish/dtrack.h"

#include <Eigen/Geometry>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::georef::GeoFix;
using adit::georef::GeoFixSet;
using adit::publish::DtrackEncoder;
using adit::publish::DtrackPair;
using adit::stereo::FixStatus;

namespace {

constexpr DtrackPair kPair{7, 1'700'000'000'123'456'000, 1'700'000'000'128'456'000, {100, 200, 0}};

GeoFix Fix(std::uint8_t target, const Eigen::Vector3d& direction) {
  GeoFix fix;
  fix.state.points.target = target;
  fix.state.points.status = FixStatus::kTracked;
  fix.position_s_m = {101.5, 198, 0.25};
  fix.direction_s = direction.normalized();
  for (std::size_t led = 0; led < fix.leds_s_m.size(); ++led)
    fix.leds_s_m[led] = fix.position_s_m + (0.1 * static_cast<double>(led)) * fix.direction_s;
  return fix;
}

std::string Encode(const GeoFixSet& fixes) {
  DtrackEncoder encoder;
  const auto datagram = encoder.Encode(fixes, kPair);
  return {datagram.begin(), datagram.end()};
}

/// The six and the nine numbers of the first body.
struct Body {
  double x, y, z, eta, theta, phi;
  Eigen::Matrix3d r;
};
Body FirstBody(const std::string& text) {
  Body body{};
  int id = -1;
  double quality = 0;
  double* const b = body.r.data();  // Eigen keeps its columns one after the other
  const int read = std::sscanf(text.c_str() + text.find("6d 1") + 5,
                               "[%d %lf][%lf %lf %lf %lf %lf %lf][%lf %lf %lf %lf %lf %lf %lf %lf %lf]", &id,
                               &quality, &body.x, &body.y, &body.z, &body.eta, &body.theta, &body.phi, b,
                               b + 1, b + 2, b + 3, b + 4, b + 5, b + 6, b + 7, b + 8);
  LONGS_EQUAL(17, read);
  return body;
}

}  // namespace

TEST_GROUP(Dtrack){};

TEST(Dtrack, WritesEachLineInItsExactForm) {
  GeoFixSet fixes;
  fixes.georeferenced = true;
  fixes.targets.push_back(Fix(0, {1, 0, 0}));
  STRCMP_EQUAL(
      "fr 7\r\nts 80000.123456\r\nts2 1700000000 123456 5000\r\n6dcal 1\r\n"
      "6d 1 [0 1.000][1500.000 -2000.000 250.000 -0.0000 0.0000 -0.0000]"
      "[1.000000 0.000000 0.000000 0.000000 1.000000 0.000000 0.000000 0.000000 1.000000]\r\n"
      "3d 4 [0 1.000][1500.000 -2000.000 250.000] [1 1.000][1600.000 -2000.000 250.000]"
      " [2 1.000][1700.000 -2000.000 250.000] [3 1.000][1800.000 -2000.000 250.000]\r\n",
      Encode(fixes).c_str());
}

TEST(Dtrack, WhatIsLostIsLeftOutAndCounted) {
  GeoFixSet fixes;
  fixes.targets.push_back(Fix(0, {1, 0, 0}));
  fixes.targets.push_back(Fix(1, {1, 0, 0}));
  fixes.targets[0].state.points.status = FixStatus::kLost;
  const std::string text = Encode(fixes);
  STRCMP_CONTAINS("6dcal 2\r\n6d 1 [1 1.000]", text.c_str());
  STRCMP_CONTAINS("3d 4 [4 1.000]", text.c_str());
  fixes.targets[1].state.points.status = FixStatus::kLost;
  STRCMP_CONTAINS("6d 0\r\n3d 0\r\n", Encode(fixes).c_str());
}

TEST(Dtrack, AnglesAndMatrixAreOneRotationWhoseXIsTheBarAndWhoseZIsNearestToUp) {
  const std::vector<Eigen::Vector3d> directions{
      {1, 0.3, 0.2}, {-1, 0.1, -0.7}, {0.2, -1, 0.9}, {0, 0, 1}, {0, 0, -1}};
  for (const bool georeferenced : {true, false}) {
    const Eigen::Vector3d up = georeferenced ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, -1, 0);
    for (const Eigen::Vector3d& direction : directions) {
      GeoFixSet fixes;
      fixes.georeferenced = georeferenced;
      fixes.targets.push_back(Fix(0, direction));
      const Body body = FirstBody(Encode(fixes));
      constexpr double kRadPerDeg = std::numbers::pi / 180;
      const Eigen::Matrix3d turned = (Eigen::AngleAxisd(body.eta * kRadPerDeg, Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(body.theta * kRadPerDeg, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(body.phi * kRadPerDeg, Eigen::Vector3d::UnitZ()))
                                         .toRotationMatrix();
      CHECK((turned - body.r).norm() < 1e-5);
      CHECK((body.r.transpose() * body.r - Eigen::Matrix3d::Identity()).norm() < 1e-5);
      CHECK(body.r.determinant() > 0);
      CHECK((body.r.col(0) - direction.normalized()).norm() < 1e-5);
      CHECK(body.r.col(2).dot(up) >= -1e-6);
      CHECK(std::abs(direction.normalized().dot(up)) > 0.99 || std::abs(body.r.col(1).dot(up)) < 1e-5);
    }
  }
}

TEST(Dtrack, HoldsAllTargetsFarFromTheOriginWithoutTheHeap) {
  GeoFixSet fixes;
  for (std::size_t i = 0; i < adit::identify::kMaxTargets; ++i) {
    fixes.targets.push_back(Fix(static_cast<std::uint8_t>(i), {-1, -0.3, -0.2}));
    fixes.targets[i].position_s_m = Eigen::Vector3d::Constant(-9e7);
    fixes.targets[i].leds_s_m.fill(Eigen::Vector3d::Constant(-9e7));
  }
  DtrackEncoder encoder;
  const std::uint64_t before = adit::support::AllocationCount();
  const auto datagram = encoder.Encode(fixes, kPair);
  LONGS_EQUAL(before, adit::support::AllocationCount());
  const std::string text(datagram.begin(), datagram.end());
  STRCMP_CONTAINS(" [127 1.000]", text.c_str());
  STRCMP_EQUAL("]\r\n", text.substr(text.size() - 3).c_str());
}
