#include "host/essential.h"

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <vector>

#include "tests/support/synthetic_rig.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::ChoosePose;
using adit::host::DecomposeEssential;
using adit::host::EssentialFromPoints;
using adit::host::RayPair;
using adit::host::RelativePose;
using adit::host::SampsonSquared;
using adit::host::Triangulate;
using adit::tests::SyntheticRig;
using adit::tests::WaveBars;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<double, 4> kPlacesM{0, 0.25, 0.65, 1.5};

std::vector<RayPair> Rays(const SyntheticRig& rig, double noise_px, std::size_t bars, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<RayPair> rays;
  adit::tests::Waving waving;
  waving.noise_px = noise_px;
  const Eigen::Vector2d centre(rig.cu_px, rig.cv_px);
  for (const auto& bar : WaveBars(rig, kPlacesM, waving, bars, random)) {
    for (std::size_t i = 0; i < 4; ++i)
      rays.push_back({(bar.left_px[i] - centre) / rig.focal_px, (bar.right_px[i] - centre) / rig.focal_px});
  }
  return rays;
}

double AngleRad(const Matrix3d& a, const Matrix3d& b) { return Eigen::AngleAxisd(a * b.transpose()).angle(); }

double AngleRad(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

TEST_GROUP(Essential) { SyntheticRig rig_ = SyntheticRig::Convergent(9, 35); };

TEST(Essential, RecoversThePoseExactlyFromExactPoints) {
  const auto rays = Rays(rig_, 0, 10, 1);

  const auto essential = EssentialFromPoints(rays);

  CHECK(essential.has_value());
  const auto pose = ChoosePose(*essential, rays);
  CHECK(pose.has_value());
  DOUBLES_EQUAL(0, AngleRad(pose->rotation, rig_.right_from_left), 1e-9);
  DOUBLES_EQUAL(0, AngleRad(pose->translation_m, rig_.right_translation_m), 1e-8);
  DOUBLES_EQUAL(1, pose->translation_m.norm(), 1e-12);
}

TEST(Essential, HasTwoEqualSingularValuesAndAZero) {
  const auto essential = EssentialFromPoints(Rays(rig_, 0.05, 30, 2));

  const Vector3d singular = Eigen::JacobiSVD<Matrix3d>(*essential).singularValues();
  DOUBLES_EQUAL(1, singular[0], 1e-12);
  DOUBLES_EQUAL(1, singular[1], 1e-12);
  DOUBLES_EQUAL(0, singular[2], 1e-12);
}

// The eight-point solution of OpenCV, which normalises as Hartley does, on the same points. It enforces rank
// two before it removes the normalisation, so the two agree to the noise that they share, not to rounding.
TEST(Essential, AgreesWithOpenCvsEightPointAlgorithm) {
  for (std::uint64_t seed = 10; seed < 20; ++seed) {
    const auto rays = Rays(rig_, 0.05, 200, seed);
    std::vector<cv::Point2d> left, right;
    for (const auto& ray : rays) {
      left.emplace_back(ray.left.x(), ray.left.y());
      right.emplace_back(ray.right.x(), ray.right.y());
    }
    Matrix3d oracle;
    cv::cv2eigen(cv::findFundamentalMat(left, right, cv::FM_8POINT), oracle);
    oracle.normalize();

    Matrix3d ours = *EssentialFromPoints(rays);
    ours.normalize();

    if ((ours.array() * oracle.array()).sum() < 0) ours = -ours;
    DOUBLES_EQUAL(0, (ours - oracle).cwiseAbs().maxCoeff(), 2e-3);
  }
}

// cv::findEssentialMat (Nister's five points) is another method: the poses agree within the noise of both.
TEST(Essential, AgreesWithOpenCvsFivePointPose) {
  const auto rays = Rays(rig_, 0.02, 300, 21);
  std::vector<cv::Point2d> left, right;
  for (const auto& ray : rays) {
    left.emplace_back(ray.left.x(), ray.left.y());
    right.emplace_back(ray.right.x(), ray.right.y());
  }
  cv::setRNGSeed(1);
  const cv::Mat e = cv::findEssentialMat(left, right, cv::Mat::eye(3, 3, CV_64F), cv::LMEDS, 0.999);
  cv::Mat r, t;
  cv::recoverPose(e, left, right, cv::Mat::eye(3, 3, CV_64F), r, t);
  Matrix3d rotation;
  Vector3d translation;
  cv::cv2eigen(r, rotation);
  cv::cv2eigen(t, translation);

  const auto pose = ChoosePose(*EssentialFromPoints(rays), rays);

  CHECK(pose.has_value());
  DOUBLES_EQUAL(0, AngleRad(pose->rotation, rotation), 0.01);
  DOUBLES_EQUAL(0, AngleRad(pose->translation_m, translation), 0.02);
}

TEST(Essential, FourPosesShareItAndOneHasThePointsInFront) {
  const auto rays = Rays(rig_, 0, 10, 3);
  const Matrix3d truth = adit::base::Skew(rig_.right_translation_m.normalized()) * rig_.right_from_left;

  int in_front = 0;
  for (const RelativePose& pose : DecomposeEssential(truth)) {
    DOUBLES_EQUAL(1, pose.rotation.determinant(), 1e-12);
    const Matrix3d again = adit::base::Skew(pose.translation_m) * pose.rotation;
    CHECK((again - truth).norm() < 1e-9 || (again + truth).norm() < 1e-9);
    bool all = true;
    for (const RayPair& ray : rays) {
      const auto point = Triangulate(pose, ray);
      all = all && point && point->depth_left > 0 && point->depth_right > 0;
    }
    in_front += all ? 1 : 0;
  }
  LONGS_EQUAL(1, in_front);
}

// Whichever of the four poses is the true one, its own points choose it: data is made for each in turn.
TEST(Essential, EveryOneOfTheFourPosesIsChosenByItsOwnPoints) {
  std::mt19937_64 random(4);
  // One camera ahead of the other: of two that stand alike, one turned about the baseline sees nothing that
  // the other does.
  const Vector3d translation_m = rig_.right_translation_m + Vector3d(0, 0, 2.3);
  const Matrix3d essential = adit::base::Skew(translation_m.normalized()) * rig_.right_from_left;
  for (const RelativePose& truth : DecomposeEssential(essential)) {
    std::vector<RayPair> rays;
    while (rays.size() < 20) {
      const Vector3d p(adit::tests::Uniform(random, -20, 20), adit::tests::Uniform(random, -20, 20),
                       adit::tests::Uniform(random, 0.1, 20));
      const Vector3d q = truth * p;
      if (q.z() > 0.1) rays.push_back({p.head<2>() / p.z(), q.head<2>() / q.z()});
    }

    const auto chosen = ChoosePose(essential, rays);

    CHECK(chosen.has_value());
    DOUBLES_EQUAL(0, AngleRad(chosen->rotation, truth.rotation), 1e-9);
    DOUBLES_EQUAL(0, (chosen->translation_m - truth.translation_m).norm(), 1e-9);
  }
}

TEST(Essential, DeclinesSevenPoints) {
  const auto rays = Rays(rig_, 0, 2, 5);
  CHECK_FALSE(EssentialFromPoints(std::span(rays).first(7)).has_value());
}

TEST(Essential, DeclinesOneBarSeenAgainAndAgain) {
  auto rays = Rays(rig_, 0, 1, 6);
  for (int i = 0; i < 3; ++i) rays.insert(rays.end(), rays.begin(), rays.begin() + 4);
  CHECK_FALSE(EssentialFromPoints(rays).has_value());
}

// Two bars are eight points but six equations: the reason why samples take more.
TEST(Essential, DeclinesTwoBars) { CHECK_FALSE(EssentialFromPoints(Rays(rig_, 0, 2, 7)).has_value()); }

TEST(Essential, SampsonDistanceIsTheShiftAcrossTheEpipolarLine) {
  // Cameras side by side: epipolar lines are rows; the two images share a shift of dy, dy^2 / 2 in all.
  const Matrix3d essential = adit::base::Skew(Vector3d(-1, 0, 0));
  const RayPair pair{{0.1, 0.02}, {0.05, 0.023}};
  DOUBLES_EQUAL(0.003 * 0.003 / 2, SampsonSquared(essential, pair), 1e-15);
}

TEST(Essential, TriangulatesAPointThatBothRaysMeet) {
  const RelativePose pose{rig_.right_from_left, rig_.right_translation_m};
  const Vector3d p(0.7, -0.9, 42);
  const Vector3d q = rig_.right_from_left * p + rig_.right_translation_m;

  const auto point = Triangulate(pose, {p.head<2>() / p.z(), q.head<2>() / q.z()});

  CHECK(point.has_value());
  DOUBLES_EQUAL(0, (point->point_l - p).norm(), 1e-9);
  DOUBLES_EQUAL(p.z(), point->depth_left, 1e-9);
  DOUBLES_EQUAL(q.z(), point->depth_right, 1e-9);
}

TEST(Essential, DeclinesRaysThatAreParallel) {
  const RelativePose pose{Matrix3d::Identity(), Vector3d(-9, 0, 0)};
  CHECK_FALSE(Triangulate(pose, {{0.1, 0.1}, {0.1, 0.1}}).has_value());
}

TEST(Essential, PutsAPointBehindTheCamerasAtANegativeDepth) {
  const RelativePose pose{Matrix3d::Identity(), Vector3d(-9, 0, 0)};
  const auto point = Triangulate(pose, {{0.0, 0.0}, {0.1, 0.0}});  // rays diverge: they meet behind
  CHECK(point.has_value());
  DOUBLES_EQUAL(-90, point->depth_left, 1e-9);
}
