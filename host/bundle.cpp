#include "host/bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "firmware/base/require.h"

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kResiduals = 16;  // 4 LEDs x 2 images x 2
constexpr int kBarSize = 6;     // centre, direction on the unit sphere
constexpr int kPoseSize = 6;    // rotation vector, translation
// Whitened residuals of a right bar have chi2 about 11 (16 residuals, 5 parameters); 31 is its 99.9 %.
constexpr double kRobustScale = 5.6;  // square root of 31
constexpr int kStepsMax = 200;

double MeanPlaceM(const base::Target& target) {
  double sum_m = 0;
  for (const double place_m : target.leds_m) sum_m += place_m;
  return sum_m / base::kLedCount;
}

/// LED residuals of one bar in both images, whitened.
struct BarCost {
  const optics::CameraModel *left, *right;
  StereoBar bar;
  std::array<double, base::kLedCount> offset_m;  // of the LEDs from their mean
  Matrix3d rotation;                             // the pose's rotation is exp(pose[0..2]) times this
  std::array<Eigen::Matrix2d, base::kLedCount> whiten_left, whiten_right;

  BarCost(const BundleInput& input, const StereoBar& measured, const Matrix3d& reference)
      : left(&input.left), right(&input.right), bar(measured), rotation(reference) {
    const base::Target& target = input.targets[measured.target];
    const auto whitener = [](const Eigen::Matrix2d& covariance_px2) {
      const Eigen::Matrix2d lower = covariance_px2.llt().matrixL();
      return Eigen::Matrix2d(lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity()));
    };
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      offset_m[i] = target.leds_m[i] - MeanPlaceM(target);
      whiten_left[i] = whitener(bar.left[i].covariance_px2);
      whiten_right[i] = whitener(bar.right[i].covariance_px2);
    }
  }

  template <class T>
  static void Residual(const optics::CameraModel& camera, const T* point, const LedView& view,
                       const Eigen::Matrix2d& whiten, T* out) {
    const T du = point[0] / point[2] * camera.fu_px + camera.cu_px - view.ideal_px.x();
    const T dv = point[1] / point[2] * camera.fv_px + camera.cv_px - view.ideal_px.y();
    out[0] = du * whiten(0, 0) + dv * whiten(0, 1);
    out[1] = du * whiten(1, 0) + dv * whiten(1, 1);
  }

  template <class T>
  bool operator()(const T* pose, const T* place, T* out) const {
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      std::array<T, 3> l{}, turned{}, r{};
      for (std::size_t k = 0; k < 3; ++k) l[k] = place[k] + place[3 + k] * offset_m[i];
      for (int k = 0; k < 3; ++k)
        turned[static_cast<std::size_t>(k)] =
            l[0] * rotation(k, 0) + l[1] * rotation(k, 1) + l[2] * rotation(k, 2);
      ceres::AngleAxisRotatePoint(pose, turned.data(), r.data());
      for (std::size_t k = 0; k < 3; ++k) r[k] += pose[3 + k];
      if (!(l[2] > 0.0) || !(r[2] > 0.0)) return false;  // a step too far: the solver takes a shorter one
      Residual(*left, l.data(), bar.left[i], whiten_left[i], out + 4 * i);
      Residual(*right, r.data(), bar.right[i], whiten_right[i], out + 4 * i + 2);
    }
    return true;
  }
};

/// The parameters and the Ceres problem over them.
struct Adjustment {
  std::array<double, kPoseSize> pose{};
  std::vector<std::array<double, kBarSize>> bars;
  std::vector<BarCost*> costs;  // owned by the problem
  ceres::Problem problem;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering = std::make_shared<ceres::ParameterBlockOrdering>();
};

void Build(const BundleInput& input, const RelativePose& start, std::span<const BarPlace> places,
           BundleLoss loss, Adjustment& a) {
  for (std::size_t k = 0; k < 3; ++k) a.pose[3 + k] = start.translation_m[static_cast<Eigen::Index>(k)];
  a.bars.resize(input.bars.size());
  auto* manifold = new ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::SphereManifold<3>>();
  auto* robust = loss == BundleLoss::kRobust ? new ceres::CauchyLoss(kRobustScale) : nullptr;
  for (std::size_t i = 0; i < input.bars.size(); ++i) {
    Eigen::Map<Vector3d>(a.bars[i].data()) = places[i].centre_l_m;
    Eigen::Map<Vector3d>(a.bars[i].data() + 3) = places[i].direction_l.normalized();
    auto* cost = new BarCost(input, input.bars[i], start.rotation);
    a.costs.push_back(cost);
    a.problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<BarCost, kResiduals, kPoseSize, kBarSize>(cost), robust,
        a.pose.data(), a.bars[i].data());
    a.problem.SetManifold(a.bars[i].data(), manifold);
    a.ordering->AddElementToGroup(a.bars[i].data(), 0);
  }
  a.ordering->AddElementToGroup(a.pose.data(), 1);
}

/// chi2 and squared pixels of one bar at the solution.
void Measure(const Adjustment& a, std::size_t i, Bundle& out) {
  std::array<double, kResiduals> whitened{};
  const BarCost& cost = *a.costs[i];
  if (!cost(a.pose.data(), a.bars[i].data(), whitened.data())) {
    out.chi2.push_back(std::numeric_limits<double>::infinity());
    out.error_px2.push_back(std::numeric_limits<double>::infinity());
    return;
  }
  double chi2 = 0, error_px2 = 0;
  for (std::size_t led = 0; led < base::kLedCount; ++led) {
    const Vector2d l(whitened[4 * led], whitened[4 * led + 1]);
    const Vector2d r(whitened[4 * led + 2], whitened[4 * led + 3]);
    chi2 += l.squaredNorm() + r.squaredNorm();
    error_px2 += cost.whiten_left[led].triangularView<Eigen::Lower>().solve(l).squaredNorm() +
                 cost.whiten_right[led].triangularView<Eigen::Lower>().solve(r).squaredNorm();
  }
  out.chi2.push_back(chi2);
  out.error_px2.push_back(error_px2);
}

/// The pose's block of the inverse normal matrix, by the Schur complement of every bar's 5 x 5 block. Ceres'
/// own Covariance factors the whole Jacobian, which takes longer than the adjustment.
std::optional<Eigen::Matrix<double, 6, 6>> PoseCovariance(const Adjustment& a) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  const ceres::SphereManifold<3> sphere;
  using RowMajor = Eigen::Matrix<double, kResiduals, 6, Eigen::RowMajor>;
  for (std::size_t i = 0; i < a.bars.size(); ++i) {
    const ceres::AutoDiffCostFunction<BarCost, kResiduals, kPoseSize, kBarSize> function(
        new BarCost(*a.costs[i]));
    RowMajor by_pose, by_bar;
    std::array<double, kResiduals> residuals{};
    const std::array<const double*, 2> parameters{a.pose.data(), a.bars[i].data()};
    std::array<double*, 2> jacobians{by_pose.data(), by_bar.data()};
    if (!function.Evaluate(parameters.data(), residuals.data(), jacobians.data())) return std::nullopt;
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> tangent;
    sphere.PlusJacobian(a.bars[i].data() + 3, tangent.data());
    Eigen::Matrix<double, kResiduals, 5> bar;
    bar << by_bar.leftCols<3>(), by_bar.rightCols<3>() * tangent;
    const Eigen::Matrix<double, 5, 5> block = bar.transpose() * bar;
    const Eigen::Matrix<double, 5, 6> cross = bar.transpose() * by_pose;
    normal += by_pose.transpose() * by_pose - cross.transpose() * block.ldlt().solve(cross);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(normal);
  // Radians and metres are of one order in information here; 1e-14 of the largest is rounding, not knowledge.
  if (!(eigen.eigenvalues()[0] > 1e-14 * eigen.eigenvalues()[5])) return std::nullopt;
  return Eigen::Matrix<double, 6, 6>(eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                                     eigen.eigenvectors().transpose());
}

}  // namespace

std::optional<BarPlace> PlaceBar(const BundleInput& input, const RelativePose& T_r_l, const StereoBar& bar) {
  const base::Target& target = input.targets[bar.target];
  Vector3d mean = Vector3d::Zero(), along = Vector3d::Zero();
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const auto led = Triangulate(
        T_r_l, {input.left.Normalised(bar.left[i].ideal_px), input.right.Normalised(bar.right[i].ideal_px)});
    if (!led || !(led->depth_left > 0) || !(led->depth_right > 0)) return std::nullopt;
    mean += led->point_l / base::kLedCount;
    along += led->point_l * (target.leds_m[i] - MeanPlaceM(target));
  }
  if (!(along.norm() > 0) || !(mean.z() > 0)) return std::nullopt;
  return BarPlace{mean, along.normalized()};
}

std::optional<Bundle> AdjustBundle(const BundleInput& input, const RelativePose& start,
                                   std::span<const BarPlace> places, BundleLoss loss) {
  ADIT_REQUIRE(places.size() == input.bars.size());
  Adjustment a;
  Build(input, start, places, loss, a);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = a.ordering;
  options.max_num_iterations = kStepsMax;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;  // more would sum in another order: the same recording must give the same digits
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &a.problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE) return std::nullopt;

  Bundle out;
  Matrix3d turn;
  ceres::AngleAxisToRotationMatrix(a.pose.data(), turn.data());  // column-major, as Eigen
  out.T_r_l = {turn * start.rotation, Vector3d(a.pose[3], a.pose[4], a.pose[5])};
  for (std::size_t i = 0; i < a.bars.size(); ++i) {
    out.places.push_back(
        {Eigen::Map<Vector3d>(a.bars[i].data()), Eigen::Map<Vector3d>(a.bars[i].data() + 3)});
    Measure(a, i, out);
  }
  if (!out.T_r_l.rotation.allFinite() || !out.T_r_l.translation_m.allFinite()) return std::nullopt;
  if (loss == BundleLoss::kLeast) out.covariance = PoseCovariance(a);
  return out;
}

}  // namespace adit::host
