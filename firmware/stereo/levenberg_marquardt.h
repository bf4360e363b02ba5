// Levenberg-Marquardt for small problems of fixed size: no heap.
#pragma once

#include <Eigen/Core>
#include <algorithm>

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

/// Minimises the sum of squared residuals over `state`, in place (Levenberg 1944, Marquardt 1963; damped as
/// Nielsen 1999, so that it holds still where the residuals bend the sum more than J^T J says).
///
/// `Problem` has kParameters, kResiduals, a copyable State, and
///   bool Evaluate(const State&, Residuals&, Jacobian&) const   false where the model has no value
///   State Moved(const State&, const Step&) const               the state a step away
/// Residuals must be whitened (unit variance): the iteration ends when a step without damping is shorter than
/// a ten thousandth of the estimate's own standard deviation. Declines (converged false) after 50 steps (a
/// bar takes two or three).
template <class Problem>
Minimum<Problem::kParameters> Minimise(const Problem& problem, typename Problem::State& state) {
  constexpr int kParameters = Problem::kParameters;
  using Residuals = Eigen::Matrix<double, Problem::kResiduals, 1>;
  using Jacobian = Eigen::Matrix<double, Problem::kResiduals, kParameters>;
  using Step = Eigen::Matrix<double, kParameters, 1>;
  constexpr int kStepsMax = 50;
  constexpr double kShortStep = 1e-8;  // squared, in standard deviations

  Minimum<kParameters> minimum;
  Residuals residuals;
  Jacobian jacobian;
  if (!problem.Evaluate(state, residuals, jacobian)) return minimum;
  minimum.cost = residuals.squaredNorm();
  double damping = 1e-6, raise = 2;
  for (int step_count = 0; step_count < kStepsMax; ++step_count) {
    minimum.information = base::Normal(jacobian);
    const Step downhill = -jacobian.transpose().lazyProduct(residuals);
    const Step damp = damping * minimum.information.diagonal();
    auto damped = minimum.information;
    if constexpr (requires { problem.AddBend(state, residuals, jacobian, damped); })
      problem.AddBend(state, residuals, jacobian, damped);
    damped.diagonal() += damp;
    const Step step = base::SolvePositive(damped, downhill);
    if (!step.allFinite()) return minimum;
    // With much damping every step is short; that says nothing.
    const Step whole = damping < 1 ? step : base::SolvePositive(minimum.information, downhill);
    const bool short_step = whole.dot(minimum.information * whole) < kShortStep;
    const typename Problem::State moved = problem.Moved(state, step);
    Residuals moved_residuals;
    Jacobian moved_jacobian;
    const bool valid = problem.Evaluate(moved, moved_residuals, moved_jacobian);
    const double moved_cost = valid ? moved_residuals.squaredNorm() : 0;
    if (valid && moved_cost <= minimum.cost) {
      const double promised = step.dot(damp.cwiseProduct(step) + downhill);
      const double surplus = 2 * (minimum.cost - moved_cost) / promised - 1;
      damping *= std::max(0.1, 1 - surplus * surplus * surplus);
      raise = 2;
      state = moved, residuals = moved_residuals, jacobian = moved_jacobian;
      minimum.cost = moved_cost;
    } else {
      damping *= raise;
      raise *= 2;
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
