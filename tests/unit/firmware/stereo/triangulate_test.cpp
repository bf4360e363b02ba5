#include "firmware/stereo/triangulate.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "tests/unit/firmware/stereo/observations.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::ObservationPair;
using adit::stereo::Triangulate;
using adit::stereo::TriangulateMidpoint;
using adit::stereo::Views;
using adit::stereo_tests::Observe;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const std::array<Vector3d, 4> kPlaces{Vector3d(2, 1, 20), Vector3d(4, -2, 32), Vector3d(6, 0, 50),
                                      Vector3d(15, 6, 105)};

cv::Mat ProjectionOf(const adit::optics::CameraModel& camera, const Matrix3d& r, const Vector3d& t) {
  Eigen::Matrix<double, 3, 4> rt;
  rt << r, t;
  const Eigen::Matrix<double, 3, 4> p = camera.K() * rt;
  cv::Mat mat(3, 4, CV_64F);
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 4; ++col) mat.at<double>(row, col) = p(row, col);
  return mat;
}

/// One centroid's whitened residual, for Ceres.
struct Reprojection {
  adit::optics::CameraModel camera;
  Matrix3d r;
  Vector3d t;
  Eigen::Vector2d px;
  Eigen::Matrix2d root_information;
  template <class T>
  bool operator()(const T* point, T* residual) const {
    const Eigen::Matrix<T, 3, 1> p =
        r.cast<T>() * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(point) + t.cast<T>();
    const Eigen::Matrix<T, 2, 1> miss(p.x() / p.z() * camera.fu_px + camera.cu_px - px.x(),
                                      p.y() / p.z() * camera.fv_px + camera.cv_px - px.y());
    Eigen::Map<Eigen::Matrix<T, 2, 1>>{residual} = root_information.cast<T>() * miss;
    return true;
  }
};

Vector3d ByCeres(const adit::optics::Rig& rig, const ObservationPair& pair, const Vector3d& start) {
  Vector3d point = start;
  ceres::Problem problem;
  for (std::size_t side = 0; side < 2; ++side) {
    // The inverse symmetric root: another whitening than ours, of the same metric.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(pair[side].covariance_px2);
    const auto cost = side == 0 ? Reprojection{rig.left, Matrix3d::Identity(), Vector3d::Zero(), pair[0].px,
                                               eigen.operatorInverseSqrt()}
                                : Reprojection{rig.right, rig.T_r_l.rotation, rig.T_r_l.translation_m,
                                               pair[1].px, eigen.operatorInverseSqrt()};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, 3>(new Reprojection(cost)),
                             nullptr, point.data());
  }
  ceres::Solver::Options options;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.max_num_iterations = 100;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return point;
}

}  // namespace

TEST_GROUP(Triangulate) {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  Views views = adit::stereo::MakeViews(rig.AsRig());
  adit::support::SyntheticScene random{rig, 11};
};

TEST(Triangulate, FindsPointsExactlyWithoutNoise) {
  for (const Vector3d& place : kPlaces) {
    const auto pair = Observe(rig, place, 0, random);
    const auto point = Triangulate(views, pair);
    const auto midpoint = TriangulateMidpoint(views, pair);
    CHECK(point && midpoint);
    CHECK((point->point_b_m - place).norm() < 1e-8 * place.norm());
    CHECK((midpoint->point_b_m - place).norm() < 1e-8 * place.norm());
  }
}

TEST(Triangulate, AgreesWithOpenCv) {
  const auto r = rig.AsRig();
  const cv::Mat left = ProjectionOf(r.left, Matrix3d::Identity(), Vector3d::Zero());
  const cv::Mat right = ProjectionOf(r.right, r.T_r_l.rotation, r.T_r_l.translation_m);
  for (const Vector3d& place : kPlaces) {
    const auto pair = Observe(rig, place, 0.05, random);
    cv::Mat a(2, 1, CV_64F), b(2, 1, CV_64F), point;
    for (int i = 0; i < 2; ++i) a.at<double>(i) = pair[0].px[i], b.at<double>(i) = pair[1].px[i];
    cv::triangulatePoints(left, right, a, b, point);
    const Vector3d by_cv =
        Vector3d(point.at<double>(0), point.at<double>(1), point.at<double>(2)) / point.at<double>(3);
    const auto ours = Triangulate(views, pair);
    CHECK(!!ours);
    // DLT weighs otherwise than the reprojection error: they differ far below the noise.
    CHECK((ours->point_b_m - by_cv).norm() < 0.02 * std::sqrt(ours->covariance_m2.trace()));
  }
}

TEST(Triangulate, AgreesWithCeresForUnequalCovariances) {
  const auto r = rig.AsRig();
  for (const Vector3d& place : kPlaces) {
    for (int trial = 0; trial < 5; ++trial) {
      auto pair = Observe(rig, place, 0.3, random);
      for (auto& observation : pair) {
        Eigen::Matrix2d root;
        root << random.Uniform(0.05, 0.6), 0, random.Uniform(-0.3, 0.3), random.Uniform(0.05, 0.6);
        observation.covariance_px2 = root * root.transpose();
      }
      const auto ours = Triangulate(views, pair);
      CHECK(!!ours);
      const Vector3d by_ceres = ByCeres(r, pair, place);
      // Ours adds 0.001 px to every noise.
      CHECK((ours->point_b_m - by_ceres).norm() < 1e-3 * std::sqrt(ours->covariance_m2.trace()));
    }
  }
}

TEST(Triangulate, ReachesTheCramerRaoBoundAndStatesIt) {
  constexpr double kSigmaPx = 0.05;
  constexpr int kTrials = 8000;
  for (const Vector3d& place : kPlaces) {
    const Matrix3d bound = adit::stereo_tests::CramerRao<3>(
        rig, kSigmaPx, [&](const Vector3d& p) { return std::vector<Vector3d>{place + p}; });
    double square_m2 = 0, nees = 0;
    Vector3d mean = Vector3d::Zero();
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto located = Triangulate(views, Observe(rig, place, kSigmaPx, random));
      CHECK(!!located);
      const Vector3d error = located->point_b_m - place;
      mean += error / kTrials;
      square_m2 += error.squaredNorm() / kTrials;
      nees += error.dot(located->covariance_m2.inverse() * error) / kTrials;
    }
    const double rms_ratio = std::sqrt(square_m2 / bound.trace());
    CHECK(rms_ratio < 1.05);
    CHECK(rms_ratio > 0.95);
    // Mean of kTrials chi-squares of 3 degrees of freedom: 3 +- 4 standard deviations.
    DOUBLES_EQUAL(3, nees, 4 * std::sqrt(6.0 / kTrials));
    CHECK(mean.norm() < 5 * std::sqrt(bound.trace() / kTrials));
  }
}

TEST(Triangulate, TheMidpointsCovarianceIsThatOfTheFullSolution) {
  for (const Vector3d& place : kPlaces) {
    const auto pair = Observe(rig, place, 0.05, random);
    const auto full = Triangulate(views, pair), quick = TriangulateMidpoint(views, pair);
    CHECK(full && quick);
    CHECK((full->covariance_m2 - quick->covariance_m2).norm() < 1e-2 * full->covariance_m2.norm());
  }
}

TEST(Triangulate, DeclinesRaysThatAreNearlyParallel) {
  // 9 m base, 5 km away, 0.5 px: the depth is anyone's guess.
  const Vector3d far = 5000 * Vector3d(0.128, 0, 1);
  const auto pair = Observe(rig, far, 0.5, random);
  CHECK_FALSE(Triangulate(views, pair).has_value());
  CHECK_FALSE(TriangulateMidpoint(views, pair).has_value());
}

TEST(Triangulate, DeclinesRaysThatAreExactlyParallel) {
  auto pair = Observe(rig, {3, 0, 30}, 0, random);
  const Vector3d ray = views[0].Ray(pair[0].px);
  const Vector3d in_right = views[1].rotation * ray;
  pair[1].px = {views[1].fu_px * in_right.x() / in_right.z() + views[1].cu_px,
                views[1].fv_px * in_right.y() / in_right.z() + views[1].cv_px};
  CHECK_FALSE(Triangulate(views, pair).has_value());
  CHECK_FALSE(TriangulateMidpoint(views, pair).has_value());
}

TEST(Triangulate, DeclinesRaysThatMeetBehindTheCameras) {
  // Left centroid far left, right centroid far right: the rays part.
  ObservationPair pair;
  pair[0].px = {20, 500};
  pair[1].px = {1380, 500};
  CHECK_FALSE(Triangulate(views, pair).has_value());
  CHECK_FALSE(TriangulateMidpoint(views, pair).has_value());
}

TEST(Triangulate, DeclinesWhatIsNoNumber) {
  auto pair = Observe(rig, {3, 0, 30}, 0.01, random);
  pair[1].px.x() = std::nan("");
  CHECK_FALSE(Triangulate(views, pair).has_value());
  CHECK_FALSE(TriangulateMidpoint(views, pair).has_value());
}
