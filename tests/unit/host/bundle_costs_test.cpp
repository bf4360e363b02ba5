#include "host/bundle_costs.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "host/simulated_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::BundleFrame;
using adit::host::BundleSetting;
using adit::host::CalibrationDraw;
using adit::host::CalibrationPlan;
using adit::host::Gauss;
using adit::host::IntrinsicMatrix;
using adit::host::Intrinsics;
using adit::host::kIntrinsics;
using Eigen::Vector3d;
using Blocks = std::vector<Eigen::VectorXd>;

/// All eight parameters of a camera free, and correlated.
adit::host::IntrinsicPrior WholePrior(adit::sim::Random& random) {
  adit::host::IntrinsicVector sigma;
  sigma << 2, 2, 1, 1, 1e-3, 1e-2, 1e-4, 1e-4;
  IntrinsicMatrix mixed;
  for (double& value : mixed.reshaped()) value = Gauss(random) / 3;
  const IntrinsicMatrix correlated = IntrinsicMatrix::Identity() + mixed * mixed.transpose();
  return adit::host::PriorOf(IntrinsicMatrix(sigma.asDiagonal() * correlated * sigma.asDiagonal()));
}

CalibrationDraw SmallDraw(std::uint64_t seed) {
  CalibrationPlan plan;
  plan.bars = 4;
  return adit::host::Draw(plan, seed);
}

BundleSetting SettingOf(const CalibrationDraw& draw) {
  return {draw.input.left,
          draw.input.right,
          draw.input.left_prior,
          draw.input.right_prior,
          draw.input.targets,
          draw.input.bar_sigma_m,
          1.3};
}

Eigen::VectorXd Residuals(const ceres::CostFunction& cost, const Blocks& blocks,
                          std::vector<double*> jacobians = {}) {
  std::vector<const double*> parameters;
  for (const Eigen::VectorXd& block : blocks) parameters.push_back(block.data());
  Eigen::VectorXd residuals(cost.num_residuals());
  CHECK(cost.Evaluate(parameters.data(), residuals.data(), jacobians.empty() ? nullptr : jacobians.data()));
  return residuals;
}

/// Analytic derivatives by block `which` against central differences, each column by its own size.
void CheckDerivatives(const ceres::CostFunction& cost, const Blocks& blocks, std::size_t which,
                      const Eigen::VectorXd& steps) {
  const Eigen::Index columns = blocks[which].size();
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> analytic(cost.num_residuals(),
                                                                                  columns);
  std::vector<double*> jacobians(blocks.size(), nullptr);
  jacobians[which] = analytic.data();
  Residuals(cost, blocks, jacobians);
  for (Eigen::Index i = 0; i < columns; ++i) {
    Blocks more = blocks, less = blocks;
    more[which][i] += steps[i], less[which][i] -= steps[i];
    const Eigen::VectorXd numeric = (Residuals(cost, more) - Residuals(cost, less)) / (2 * steps[i]);
    CHECK_COMPARE(numeric.norm(), >, 0);
    DOUBLES_EQUAL(0, (analytic.col(i) - numeric).norm() / numeric.norm(), 1e-6);
  }
}

Eigen::VectorXd Steps(std::initializer_list<double> steps) {
  return Eigen::Map<const Eigen::VectorXd>(steps.begin(), static_cast<Eigen::Index>(steps.size()));
}

const Eigen::VectorXd kPoseSteps = Steps({1e-6, 1e-6, 1e-6, 1e-5, 1e-5, 1e-5});
const Eigen::VectorXd kCameraSteps = Eigen::VectorXd::Constant(kIntrinsics, 1e-3);

/// Pose, both cameras: off the start by `turn_rad` about some axis, and by about a sigma each.
Blocks Shared(const CalibrationDraw& draw, double turn_rad, adit::sim::Random& random) {
  Eigen::VectorXd pose(6);
  const Vector3d axis(Gauss(random), Gauss(random), Gauss(random));
  pose << turn_rad * axis.normalized(), draw.rig.translation_m + 0.01 * axis;
  Blocks blocks{pose, Eigen::VectorXd(kIntrinsics), Eigen::VectorXd(kIntrinsics)};
  for (const std::size_t side : {std::size_t{1}, std::size_t{2}}) {
    for (double& z : blocks[side]) z = Gauss(random);
  }
  return blocks;
}

}  // namespace

TEST_GROUP(BundleCosts){};

TEST(BundleCosts, DerivativesOfABarAreThoseOfDifferences) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    adit::sim::Random random(seed, 1);
    CalibrationDraw draw = SmallDraw(seed);
    draw.input.left_prior = WholePrior(random), draw.input.right_prior = WholePrior(random);
    const BundleSetting setting = SettingOf(draw);
    // No turn, one on either side of the series' limit, and one far off.
    for (const double turn_rad : {0.0, 5e-5, 2e-4, 0.05}) {
      const adit::host::BarCost cost({&setting, draw.rig.rotation}, draw.input.bars[0],
                                     draw.bars[0].direction);
      Blocks blocks = Shared(draw, turn_rad, random);
      blocks.push_back(Steps({Gauss(random)}));
      const Vector3d middle_m = draw.bars[0].led1_m + 0.4 * draw.bars[0].direction;
      blocks.push_back(Steps({middle_m.x(), middle_m.y(), middle_m.z(), 0.02, -0.03}));
      CheckDerivatives(cost, blocks, 0, kPoseSteps);
      CheckDerivatives(cost, blocks, 1, kCameraSteps);
      CheckDerivatives(cost, blocks, 2, kCameraSteps);
      CheckDerivatives(cost, blocks, 3, Steps({1e-2}));
      CheckDerivatives(cost, blocks, 4, Steps({1e-5, 1e-5, 1e-5, 1e-6, 1e-6}));
    }
  }
}

TEST(BundleCosts, DerivativesOfAPointAreThoseOfDifferences) {
  for (std::uint64_t seed = 11; seed <= 15; ++seed) {
    adit::sim::Random random(seed, 1);
    CalibrationDraw draw = SmallDraw(seed);
    draw.input.left_prior = WholePrior(random), draw.input.right_prior = WholePrior(random);
    const BundleSetting setting = SettingOf(draw);
    const adit::host::PointCost cost({&setting, draw.rig.rotation},
                                     {draw.input.bars[0].left[2], draw.input.bars[0].right[2]});
    Blocks blocks = Shared(draw, 0.01, random);
    const Vector3d& led1_m = draw.bars[0].led1_m;
    blocks.push_back(Steps({led1_m.x(), led1_m.y(), led1_m.z()}));
    CheckDerivatives(cost, blocks, 0, kPoseSteps);
    CheckDerivatives(cost, blocks, 1, kCameraSteps);
    CheckDerivatives(cost, blocks, 2, kCameraSteps);
    CheckDerivatives(cost, blocks, 3, Steps({1e-5, 1e-5, 1e-5}));
  }
}

// The truth projects by code of its own: at it nothing is left, whatever the camera files said.
TEST(BundleCosts, NothingIsLeftAtTheTruth) {
  CalibrationPlan plan;
  plan.bars = 20;
  CalibrationDraw draw = adit::host::Draw(plan, 21);
  const BundleSetting setting = SettingOf(draw);
  std::array<double, 4> leds_m = plan.leds_m;
  for (double& place_m : leds_m) place_m *= draw.length_scale;
  Eigen::VectorXd pose = Eigen::VectorXd::Zero(6);
  pose.tail<3>() = draw.rig.translation_m;
  for (std::size_t k = 0; k < draw.bars.size(); ++k) {
    const auto& truth = draw.bars[k];
    const auto seen = adit::host::Seen(draw.rig, truth, leds_m);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      draw.input.bars[k].left[i].raw_px = seen[i].head<2>();
      draw.input.bars[k].right[i].raw_px = seen[i].tail<2>();
    }
    const adit::host::BarCost cost({&setting, draw.rig.rotation}, draw.input.bars[k], truth.direction);
    const Vector3d centre_m = truth.led1_m + draw.length_scale * (0.25 + 0.53 + 0.82) / 4 * truth.direction;
    const double length_step = (draw.length_scale - 1) * setting.targets[0].LengthM() / setting.bar_sigma_m;
    const Blocks blocks{pose, setting.left_prior.Steps(Intrinsics(setting.left), draw.rig.left),
                        setting.right_prior.Steps(Intrinsics(setting.right), draw.rig.right),
                        Steps({length_step}), Steps({centre_m.x(), centre_m.y(), centre_m.z(), 0, 0})};
    const Eigen::VectorXd residuals = Residuals(cost, blocks);
    DOUBLES_EQUAL(0, residuals.norm() * plan.noise_px, 1e-7);  // px
  }
}

TEST(BundleCosts, APointBehindACameraIsDeclined) {
  const CalibrationDraw draw = SmallDraw(31);
  const BundleSetting setting = SettingOf(draw);
  const adit::host::PointCost cost({&setting, draw.rig.rotation},
                                   {draw.input.bars[0].left[0], draw.input.bars[0].right[0]});
  const std::array<double, 6> pose{};
  const std::array<double, kIntrinsics> camera{};
  const std::array<double, 3> behind{0, 0, -5};
  const std::array<const double*, 4> parameters{pose.data(), camera.data(), camera.data(), behind.data()};
  std::array<double, 4> residuals{};
  CHECK_FALSE(cost.Evaluate(parameters.data(), residuals.data(), nullptr));
}
