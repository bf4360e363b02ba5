#include "host/intrinsics_bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <limits>
#include <memory>

#include "firmware/base/require.h"
#include "firmware/base/symmetric.h"

namespace adit::host {
namespace {

constexpr int kBoardPoseSize = 6;  // rotation vector, translation
constexpr int kSolverStepsMax = 500;

/// Model minus measurement of one corner, px. Written out here, not by CameraModel: Ceres differentiates it.
struct CornerCost {
  BoardCorner corner;

  template <class T>
  bool operator()(const T* k, const T* pose, T* out) const {
    const std::array<T, 3> board{T(corner.board_m.x()), T(corner.board_m.y()), T(0)};
    std::array<T, 3> c{};
    ceres::AngleAxisRotatePoint(pose, board.data(), c.data());
    for (std::size_t i = 0; i < 3; ++i) c[i] += pose[3 + i];
    if (!(c[2] > 0.0)) return false;  // a step too far: the solver takes a shorter one
    const T x = c[0] / c[2], y = c[1] / c[2];
    const T r2 = x * x + y * y;
    const T radial = 1.0 + r2 * (k[4] + r2 * k[5]);
    const T xd = x * radial + 2.0 * k[6] * x * y + k[7] * (r2 + 2.0 * x * x);
    const T yd = y * radial + k[6] * (r2 + 2.0 * y * y) + 2.0 * k[7] * x * y;
    out[0] = k[0] * xd + k[2] - corner.image_px.x();
    out[1] = k[1] * yd + k[3] - corner.image_px.y();
    return true;
  }
};

using CornerFunction = ceres::AutoDiffCostFunction<CornerCost, 2, kIntrinsics, kBoardPoseSize>;

/// The parameters, and the Ceres problem over them.
struct IntrinsicsProblem {
  IntrinsicVector intrinsics;
  std::vector<std::array<double, kBoardPoseSize>> poses;
  ceres::Problem problem;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering = std::make_shared<ceres::ParameterBlockOrdering>();
};

void BuildIntrinsics(std::span<const BoardView> views, std::span<const BoardPose> poses,
                     std::optional<double> robust_px, IntrinsicsProblem& p) {
  p.poses.resize(views.size());
  auto* loss = robust_px ? new ceres::CauchyLoss(*robust_px) : nullptr;
  for (std::size_t i = 0; i < views.size(); ++i) {
    Eigen::Map<Eigen::Vector3d>(p.poses[i].data()) = poses[i].rotation_rad;
    Eigen::Map<Eigen::Vector3d>(p.poses[i].data() + 3) = poses[i].translation_m;
    for (const BoardCorner& corner : views[i].corners) {
      p.problem.AddResidualBlock(new CornerFunction(new CornerCost{corner}), loss, p.intrinsics.data(),
                                 p.poses[i].data());
    }
    p.ordering->AddElementToGroup(p.poses[i].data(), 0);
  }
  p.ordering->AddElementToGroup(p.intrinsics.data(), 1);
}

/// Residuals of one view, and its share of the reduced normal equations.
void MeasureView(const BoardView& view, const IntrinsicVector& intrinsics,
                 const std::array<double, kBoardPoseSize>& pose, IntrinsicsBundle& out) {
  ImageShare share;
  Eigen::Matrix<double, kBoardPoseSize, 1> pose_gradient = Eigen::Matrix<double, kBoardPoseSize, 1>::Zero();
  Eigen::Matrix<double, kBoardPoseSize, kBoardPoseSize> block;
  Eigen::Matrix<double, kBoardPoseSize, kIntrinsics> cross;
  block.setZero();
  cross.setZero();
  std::vector<Eigen::Vector2d> residuals_px;
  for (const BoardCorner& corner : view.corners) {
    const CornerFunction function(new CornerCost{corner});
    Eigen::Vector2d residual;
    Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor> by_camera;
    Eigen::Matrix<double, 2, kBoardPoseSize, Eigen::RowMajor> by_pose;
    const std::array<const double*, 2> parameters{intrinsics.data(), pose.data()};
    std::array<double*, 2> jacobians{by_camera.data(), by_pose.data()};
    if (!function.Evaluate(parameters.data(), residual.data(), jacobians.data())) {
      residuals_px.push_back(Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
      continue;
    }
    residuals_px.push_back(residual);
    share.information += by_camera.transpose() * by_camera;
    share.gradient += by_camera.transpose() * residual;
    pose_gradient += by_pose.transpose() * residual;
    block += by_pose.transpose() * by_pose;
    cross += by_pose.transpose() * by_camera;
  }
  share.information -= cross.transpose() * base::SolveSymmetric(block, cross);
  share.gradient -= cross.transpose() * base::SolveSymmetric(block, pose_gradient);
  out.shares.push_back(share);
  out.residuals_px.push_back(std::move(residuals_px));
}

}  // namespace

IntrinsicMatrix IntrinsicsBundle::Information() const {
  IntrinsicMatrix sum = IntrinsicMatrix::Zero();
  for (const ImageShare& share : shares) sum += share.information;
  return sum;
}

std::optional<IntrinsicsBundle> AdjustIntrinsics(std::span<const BoardView> views,
                                                 const optics::CameraModel& start,
                                                 std::span<const BoardPose> poses,
                                                 std::optional<double> robust_px) {
  ADIT_REQUIRE(poses.size() == views.size());
  IntrinsicsProblem p;
  p.intrinsics = Intrinsics(start);
  BuildIntrinsics(views, poses, robust_px, p);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = p.ordering;
  options.max_num_iterations = kSolverStepsMax;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;  // more would sum in another order: the same images must give the same digits
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &p.problem, &summary);
  if (!summary.IsSolutionUsable() || !p.intrinsics.allFinite()) return std::nullopt;

  IntrinsicsBundle out;
  out.camera = CameraOf(p.intrinsics, start);
  for (std::size_t i = 0; i < views.size(); ++i) {
    out.poses.push_back(
        {Eigen::Map<Eigen::Vector3d>(p.poses[i].data()), Eigen::Map<Eigen::Vector3d>(p.poses[i].data() + 3)});
    MeasureView(views[i], p.intrinsics, p.poses[i], out);
  }
  if (!out.Information().allFinite()) return std::nullopt;
  return out;
}

}  // namespace adit::host
