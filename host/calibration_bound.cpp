#include "host/calibration_bound.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "host/normal_matrix.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr int kResiduals = 4 * base::kLedCount;
constexpr int kRig = optics::kRigParameters;
constexpr int kShared = kRig + 1;  // and the bar's length, relative
constexpr int kPlace = 5;
using Observation = Eigen::Matrix<double, kResiduals, 1>;

/// Rig, length and place of a bar, all moved by steps.
struct Step {
  RigVector rig = RigVector::Zero();
  double length = 0;
  Eigen::Matrix<double, kPlace, 1> place = Eigen::Matrix<double, kPlace, 1>::Zero();
};

Observation Observe(const CalibrationPlan& plan, const TrueRig& rig, const TrueBar& bar, const Step& step) {
  const Vector3d first = bar.direction.unitOrthogonal(), second = bar.direction.cross(first);
  const TrueBar moved{bar.led1_m + step.place.head<3>(),
                      (bar.direction + step.place[3] * first + step.place[4] * second).normalized()};
  Observation out;
  for (int i = 0; i < base::kLedCount; ++i) {
    const double place_m = plan.leds_m[static_cast<std::size_t>(i)] * (1 + step.length);
    out.segment<4>(4 * i) = rig.Project(moved.led1_m + place_m * moved.direction);
  }
  return out;
}

RigVector StepSizes() {
  RigVector steps;
  IntrinsicVector camera;
  camera << 0.01, 0.01, 0.01, 0.01, 1e-5, 1e-4, 1e-6, 1e-6;
  steps << 1e-6, 1e-6, 1e-6, 1e-5, 1e-5, 1e-5, camera, camera;
  return steps;
}

/// What one bar tells of the shared parameters, its place eliminated, for noise of 1 px.
Eigen::MatrixXd Share(const CalibrationPlan& plan, const std::vector<TrueRig>& moved, const TrueRig& rig,
                      const TrueBar& bar) {
  Eigen::MatrixXd shared(kResiduals, kShared), place(kResiduals, kPlace);
  const RigVector steps = StepSizes();
  for (int i = 0; i < kRig; ++i) {
    shared.col(i) = (Observe(plan, moved[static_cast<std::size_t>(2 * i)], bar, {}) -
                     Observe(plan, moved[static_cast<std::size_t>(2 * i + 1)], bar, {})) /
                    (2 * steps[i]);
  }
  constexpr double kStep = 1e-5;
  Step more, less;
  more.length = kStep, less.length = -kStep;
  shared.col(kRig) = (Observe(plan, rig, bar, more) - Observe(plan, rig, bar, less)) / (2 * kStep);
  for (int i = 0; i < kPlace; ++i) {
    Step up, down;
    up.place[i] = kStep, down.place[i] = -kStep;
    place.col(i) = (Observe(plan, rig, bar, up) - Observe(plan, rig, bar, down)) / (2 * kStep);
  }
  return ReducedNormalMatrix(shared, place);
}

}  // namespace

std::optional<optics::RigCovariance> CalibrationBound(const CalibrationPlan& plan,
                                                      const CalibrationDraw& draw) {
  std::vector<TrueRig> moved;
  const RigVector steps = StepSizes();
  for (int i = 0; i < kRig; ++i) {
    moved.push_back(draw.rig.Moved(steps[i] * RigVector::Unit(i)));
    moved.push_back(draw.rig.Moved(-steps[i] * RigVector::Unit(i)));
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kShared, kShared);
  for (const TrueBar& bar : draw.bars) information += Share(plan, moved, draw.rig, bar);
  information /= plan.noise_px * plan.noise_px;
  // In units of the priors' sigmas, so that what is known exactly has a place too.
  Eigen::MatrixXd units = Eigen::MatrixXd::Identity(kShared, kShared);
  units.block<kIntrinsics, kIntrinsics>(6, 6) = draw.input.left_prior.root;
  units.block<kIntrinsics, kIntrinsics>(6 + kIntrinsics, 6 + kIntrinsics) = draw.input.right_prior.root;
  units(kRig, kRig) = plan.bar_sigma_m / plan.leds_m.back();
  information = (units.transpose() * information * units).eval();
  information.diagonal().tail(kShared - 6).array() += 1;
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Spectrum spectrum = SpectrumOf(scale.asDiagonal() * information * scale.asDiagonal());
  // Written so that NaN declines; what is smaller is rounding.
  const double rounding = kShared * std::numeric_limits<double>::epsilon() * spectrum.values[kShared - 1];
  if (!(spectrum.values[0] > rounding)) return std::nullopt;
  const Eigen::MatrixXd root =
      units * scale.asDiagonal() * spectrum.vectors * spectrum.values.cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = root * root.transpose();
  return optics::RigCovariance(inverse.topLeftCorner<kRig, kRig>());
}

double LengthBound(const CalibrationPlan& plan, const TrueRig& rig, const TrueBar& bar) {
  double variance = 0;
  for (const double place_m : {plan.leds_m.front(), plan.leds_m.back()}) {
    const Vector3d point = bar.led1_m + place_m * bar.direction;
    Eigen::Matrix<double, 4, 3> jacobian;
    constexpr double kStepM = 1e-5;
    for (int i = 0; i < 3; ++i) {
      const Vector3d step = kStepM * Vector3d::Unit(i);
      jacobian.col(i) = (rig.Project(point + step) - rig.Project(point - step)) / (2 * kStepM);
    }
    variance += bar.direction.dot((jacobian.transpose() * jacobian).inverse() * bar.direction);
  }
  return plan.noise_px * std::sqrt(variance);
}

}  // namespace adit::host
