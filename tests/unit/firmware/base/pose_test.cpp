#include "firmware/base/pose.h"

#include <random>

#include <CppUTest/TestHarness.h>

using adit::base::LeftCamera;
using adit::base::Pose;
using adit::base::Rig;
using adit::base::RightCamera;
using adit::base::Site;
using adit::base::Skew;

namespace {

constexpr unsigned kPoseSeed = 20;

template <class To, class From>
Pose<To, From> RandomPose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  return {q.normalized().toRotationMatrix(), {10 * normal(random), 10 * normal(random), 10 * normal(random)}};
}

Eigen::Vector3d RandomPoint(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 50);
  return {normal(random), normal(random), normal(random)};
}

// A product compiles only where the inner frames agree.
template <class A, class B>
concept Multiplies = requires(A a, B b) {
  a* b;
};
static_assert(Multiplies<Pose<Site, Rig>, Pose<Rig, LeftCamera>>);
static_assert(!Multiplies<Pose<Site, Rig>, Pose<LeftCamera, Rig>>);
static_assert(!Multiplies<Pose<Site, Rig>, Pose<Site, Rig>>);

}  // namespace

TEST_GROUP(Pose){};

TEST(Pose, IsTheIdentityUnlessToldOtherwise) {
  const Pose<Site, Rig> pose;
  CHECK_TRUE((pose * Eigen::Vector3d(1, 2, 3)) == Eigen::Vector3d(1, 2, 3));
}

TEST(Pose, MapsAPointByAQuarterTurnAndAShift) {
  // A quarter turn about z takes x to y.
  Pose<Site, Rig> pose;
  pose.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  pose.translation_m = {10, 20, 30};
  CHECK_TRUE((pose * Eigen::Vector3d(1, 0, 0)) == Eigen::Vector3d(10, 21, 30));
}

TEST(Pose, ComposesAsMappingOneAfterTheOther_Seed20) {
  std::mt19937 random(kPoseSeed);
  for (int i = 0; i < 100; ++i) {
    const auto s_b = RandomPose<Site, Rig>(random);
    const auto b_l = RandomPose<Rig, LeftCamera>(random);
    const Eigen::Vector3d point_m = RandomPoint(random);
    DOUBLES_EQUAL(0, ((s_b * b_l) * point_m - s_b * (b_l * point_m)).norm(), 1e-12);
  }
}

TEST(Pose, ComesBackByItsInverse_Seed20) {
  std::mt19937 random(kPoseSeed);
  for (int i = 0; i < 100; ++i) {
    const auto r_l = RandomPose<RightCamera, LeftCamera>(random);
    const Eigen::Vector3d point_m = RandomPoint(random);
    DOUBLES_EQUAL(0, (r_l.Inverse() * (r_l * point_m) - point_m).norm(), 1e-12);
    DOUBLES_EQUAL(0, (r_l * (r_l.Inverse() * point_m) - point_m).norm(), 1e-12);
  }
}

TEST(Pose, SkewIsTheCrossProduct_Seed20) {
  std::mt19937 random(kPoseSeed);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = RandomPoint(random), b = RandomPoint(random);
    DOUBLES_EQUAL(0, (Skew(a) * b - a.cross(b)).norm(), 1e-9);
  }
}
