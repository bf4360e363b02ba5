// What a measurement does to a Kalman filter.
#pragma once

#include "firmware/base/symmetric.h"

namespace adit::track {

/// Takes a measurement of H x with the covariance `noise` into the covariance P of a state x, and returns the
/// step of the state, with the gain K = P Hᵀ (H P Hᵀ + R)⁻¹ that is K times the innovation. P becomes (1 - K
/// H) P (1 - K H)ᵀ + K R Kᵀ (Joseph's form, which stays symmetric and positive). `h` is H's part by the
/// leading parameters of the state; its rest is zero. No heap.
template <int kMeasured, int kLeading, int kState>
Eigen::Matrix<double, kState, 1> TakeIn(const Eigen::Matrix<double, kMeasured, kLeading>& h,
                                        const Eigen::Matrix<double, kMeasured, kMeasured>& noise,
                                        const Eigen::Matrix<double, kMeasured, 1>& innovation,
                                        Eigen::Matrix<double, kState, kState>& covariance) {
  // lazyProduct everywhere: for factors this small Eigen's blocked product costs more than it saves.
  const Eigen::Matrix<double, kMeasured, kState> h_p = h.lazyProduct(covariance.template topRows<kLeading>());
  const Eigen::Matrix<double, kMeasured, kMeasured> s =
      h_p.template leftCols<kLeading>().lazyProduct(h.transpose()) + noise;
  const Eigen::Matrix<double, kMeasured, kState> gain = base::SolvePositive(s, h_p);  // transposed
  // (1 - K H) P first; what is left of Joseph's form is that - (that Hᵀ - K R) Kᵀ.
  covariance -= gain.transpose().lazyProduct(h_p);
  const Eigen::Matrix<double, kState, kMeasured> beyond =
      covariance.template leftCols<kLeading>().lazyProduct(h.transpose()) -
      gain.transpose().lazyProduct(noise);
  covariance -= beyond.lazyProduct(gain);
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  return gain.transpose().lazyProduct(innovation);
}

}  // namespace adit::track
