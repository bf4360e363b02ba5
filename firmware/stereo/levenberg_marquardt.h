// Levenberg-Marquardt for small problems of fixed size: no heap.
#pragma once

#include <Eigen/Core>

#include "firmware/base/symmetric.h"

namespace adit::stereo {

/// How a minimisation ended.
template <int kParameters>
struct Minimum {
  bool converged = false;
  double cost = 0;  ///< sum of the squared residuals
  /// J^T J at the end; its inverse is the covariance when the residuals have unit variance.
  Eigen::Matrix<double, kParameters, kParameters> information =
      Eigen::Matrix<double, kParameters, kParameters>::Zero();
};

/// Minimises the sum of squared residuals over `state`, in place (Levenberg 1944, Marquardt 1963).
///
/// `Problem` has kParameters, kResiduals, a copyable State, and
///   bool Evaluate(const State&, Residuals&, Jacobian&) const   false where the model has no value
///   State Moved(const State&, const Step&) const               the state a step away
/// Residuals must be whitened (unit variance): the iteration ends with a step that is shorter than a
/// thousandth of the estimate's own standard deviation. Declines (converged false) after 50 steps (a bar
/// takes two or three).
template <class Problem>
Minimum<Problem::kParameters> Minimise(const Problem& problem, typename Problem::State& state) {
  constexpr int kParameters = Problem::kParameters;
  using Residuals = Eigen::Matrix<double, Problem::kResiduals, 1>;
  using Jacobian = Eigen::Matrix<double, Problem::kResiduals, kParameters>;
  using Step = Eigen::Matrix<double, kParameters, 1>;
  constexpr int kStepsMax = 50;
  constexpr double kShortStep = 1e-6;  // squared, in standard deviations

  Minimum<kParameters> minimum;
  Residuals residuals;
  Jacobian jacobian;
  if (!problem.Evaluate(state, residuals, jacobian)) return minimum;
  minimum.cost = residuals.squaredNorm();
  double damping = 1e-6;
  for (int step_count = 0; step_count < kStepsMax; ++step_count) {
    minimum.information = base::Normal(jacobian);
    auto damped = minimum.information;
    damped.diagonal() *= 1 + damping;
    const Step downhill = -jacobian.transpose().lazyProduct(residuals);
    const Step step = base::SolvePositive(damped, downhill);
    if (!step.allFinite()) return minimum;
    // With much damping every step is short; that says nothing.
    const bool short_step = damping < 1 && step.dot(minimum.information * step) < kShortStep;
    const typename Problem::State moved = problem.Moved(state, step);
    Residuals moved_residuals;
    Jacobian moved_jacobian;
    const bool valid = problem.Evaluate(moved, moved_residuals, moved_jacobian);
    const double moved_cost = valid ? moved_residuals.squaredNorm() : 0;
    if (valid && moved_cost <= minimum.cost) {
      state = moved, residuals = moved_residuals, jacobian = moved_jacobian;
      minimum.cost = moved_cost;
      damping *= 0.1;
    } else {
      damping *= 10;
    }
    if (short_step) {
      minimum.information = base::Normal(jacobian);
      minimum.converged = true;
      return minimum;
    }
  }
  return minimum;
}

}  // namespace adit::stereo
