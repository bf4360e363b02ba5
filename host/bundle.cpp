#include "host/bundle.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "firmware/base/require.h"
#include "host/bundle_costs.h"
#include "host/bundle_covariance.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;

// Whitened residuals of a right bar have chi2 about 11 (16 residuals, 5 parameters); 31 is its 99.9 %. Those
// of a point: 1 degree of freedom, 10.8.
constexpr double kRobustScale = 5.6, kRobustPointScale = 3.3;  // square roots of them
constexpr int kStepsMax = 200;

double MeanPlaceM(const base::Target& target) {
  double sum_m = 0;
  for (const double place_m : target.leds_m) sum_m += place_m;
  return sum_m / base::kLedCount;
}

/// The parameters and the Ceres problem over them.
struct Adjustment {
  std::array<double, kPoseSize> pose{};
  std::array<std::array<double, kIntrinsics>, 2> cameras{};
  std::vector<double> lengths;  // steps in sigmas, one a target
  std::vector<std::array<double, kBarSize>> bars;
  std::vector<std::array<double, kPointSize>> points;
  std::vector<BarCost*> costs;  // owned by the problem
  ceres::Problem problem;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering = std::make_shared<ceres::ParameterBlockOrdering>();
};

template <std::size_t kSize>
void AddPrior(std::array<double, kSize>& block, bool is_exact, Adjustment& a) {
  a.problem.AddParameterBlock(block.data(), kSize);
  a.ordering->AddElementToGroup(block.data(), 1);
  if (is_exact) {
    a.problem.SetParameterBlockConstant(block.data());
  } else {
    a.problem.AddResidualBlock(new UnitPrior<static_cast<int>(kSize)>, nullptr, block.data());
  }
}

void AddCameras(const BundleSetting& setting, const BundleState& start, Adjustment& a) {
  Eigen::Map<Vector3d>(a.pose.data() + 3) = start.T_r_l.translation_m;
  a.problem.AddParameterBlock(a.pose.data(), kPoseSize);
  a.ordering->AddElementToGroup(a.pose.data(), 1);
  Eigen::Map<IntrinsicVector>(a.cameras[0].data()) =
      setting.left_prior.Steps(Intrinsics(setting.left), Intrinsics(start.left));
  Eigen::Map<IntrinsicVector>(a.cameras[1].data()) =
      setting.right_prior.Steps(Intrinsics(setting.right), Intrinsics(start.right));
  AddPrior(a.cameras[0], setting.left_prior.IsExact(), a);
  AddPrior(a.cameras[1], setting.right_prior.IsExact(), a);
  for (std::size_t i = 0; i < setting.targets.size(); ++i) {
    const double sigma = setting.bar_sigma_m / setting.targets[i].LengthM();
    a.lengths.push_back(sigma > 0 ? (start.length_scale[i] - 1) / sigma : 0);
  }
  for (double& length : a.lengths) {
    a.problem.AddParameterBlock(&length, 1);
    a.ordering->AddElementToGroup(&length, 1);
    if (setting.bar_sigma_m > 0) {
      a.problem.AddResidualBlock(new UnitPrior<1>, nullptr, &length);
    } else {
      a.problem.SetParameterBlockConstant(&length);
    }
  }
}

void AddData(const BundleFrame& frame, const BundleData& data, const BundleState& start, BundleLoss loss,
             Adjustment& a) {
  const auto robust = [loss](double scale) {
    return loss == BundleLoss::kRobust ? new ceres::CauchyLoss(scale) : nullptr;
  };
  a.bars.resize(data.bars.size());
  a.points.resize(data.points.size());
  ceres::LossFunction *bar_loss = data.bars.empty() ? nullptr : robust(kRobustScale),
                      *point_loss = data.points.empty() ? nullptr : robust(kRobustPointScale);
  for (std::size_t i = 0; i < data.bars.size(); ++i) {
    Eigen::Map<Vector3d>(a.bars[i].data()) = start.places[i].centre_l_m;
    a.costs.push_back(new BarCost(frame, data.bars[i], start.places[i].direction_l));
    a.problem.AddResidualBlock(a.costs.back(), bar_loss, a.pose.data(), a.cameras[0].data(),
                               a.cameras[1].data(), &a.lengths[data.bars[i].target], a.bars[i].data());
    a.ordering->AddElementToGroup(a.bars[i].data(), 0);
  }
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    Eigen::Map<Vector3d>(a.points[i].data()) = start.points_l_m[i];
    a.problem.AddResidualBlock(new PointCost(frame, data.points[i]), point_loss, a.pose.data(),
                               a.cameras[0].data(), a.cameras[1].data(), a.points[i].data());
    a.ordering->AddElementToGroup(a.points[i].data(), 0);
  }
}

BundleState StateOf(const BundleFrame& frame, const Adjustment& a) {
  const BundleSetting& setting = *frame.setting;
  const BundleCameras cameras(frame, a.pose.data(), a.cameras[0].data(), a.cameras[1].data());
  BundleState state{cameras.left, cameras.right, {cameras.rotation, cameras.translation_m}, {}, {}, {}};
  for (std::size_t i = 0; i < a.lengths.size(); ++i)
    state.length_scale.push_back(1 + a.lengths[i] * setting.bar_sigma_m / setting.targets[i].LengthM());
  for (std::size_t i = 0; i < a.bars.size(); ++i) {
    state.places.push_back(
        {Eigen::Map<const Vector3d>(a.bars[i].data()), a.costs[i]->Chart().Direction(a.bars[i].data() + 3)});
  }
  for (const auto& point : a.points) state.points_l_m.emplace_back(point[0], point[1], point[2]);
  return state;
}

/// chi2 and squared pixels of every bar and point at the solution.
void Measure(const BundleFrame& frame, const BundleData& data, const Adjustment& a, Bundle& out) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::array<double, kBarResiduals> residuals{};
  for (std::size_t i = 0; i < a.bars.size(); ++i) {
    const std::array<const double*, 5> parameters{a.pose.data(), a.cameras[0].data(), a.cameras[1].data(),
                                                  &a.lengths[data.bars[i].target], a.bars[i].data()};
    const bool valid = a.costs[i]->Evaluate(parameters.data(), residuals.data(), nullptr);
    out.chi2.push_back(
        valid ? Eigen::Map<Eigen::Matrix<double, kBarResiduals, 1>>(residuals.data()).squaredNorm() : kNever);
    out.error_px2.push_back(valid ? a.costs[i]->SquaredPx(residuals.data()) : kNever);
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const std::array<const double*, 4> parameters{a.pose.data(), a.cameras[0].data(), a.cameras[1].data(),
                                                  a.points[i].data()};
    const bool valid =
        PointCost(frame, data.points[i]).Evaluate(parameters.data(), residuals.data(), nullptr);
    out.point_chi2.push_back(valid ? Eigen::Map<Eigen::Vector4d>(residuals.data()).squaredNorm() : kNever);
  }
}

}  // namespace

std::optional<BarPlace> PlaceBar(const optics::Rig& rig, const StereoBar& bar, const base::Target& target) {
  Vector3d mean = Vector3d::Zero(), along = Vector3d::Zero();
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const auto led = Triangulate(
        rig.T_r_l, {rig.left.Normalised(bar.left[i].ideal_px), rig.right.Normalised(bar.right[i].ideal_px)});
    if (!led || !(led->depth_left > 0) || !(led->depth_right > 0)) return std::nullopt;
    mean += led->point_l / base::kLedCount;
    along += led->point_l * (target.leds_m[i] - MeanPlaceM(target));
  }
  if (!(along.norm() > 0) || !(mean.z() > 0)) return std::nullopt;
  return BarPlace{mean, along.normalized()};
}

std::optional<Bundle> AdjustBundle(const BundleSetting& setting, const BundleData& data,
                                   const BundleState& start, BundleLoss loss) {
  ADIT_REQUIRE(start.places.size() == data.bars.size() && start.points_l_m.size() == data.points.size() &&
               start.length_scale.size() == setting.targets.size());
  Adjustment a;
  const BundleFrame frame{&setting, start.T_r_l.rotation};
  AddCameras(setting, start, a);
  AddData(frame, data, start, loss, a);
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
  out.state = StateOf(frame, a);
  if (!out.state.T_r_l.rotation.allFinite() || !out.state.T_r_l.translation_m.allFinite())
    return std::nullopt;
  Measure(frame, data, a, out);
  if (loss == BundleLoss::kLeast) out.covariance = BundleCovariance(setting, data, out.state);
  return out;
}

}  // namespace adit::host
