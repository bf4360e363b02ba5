// The update of a Kalman filter, compiled once for all sizes of state.
#pragma once

#include "firmware/base/symmetric.h"

namespace adit::track {

/// A measurement of `h` x with the covariance `noise`, and by how much it misses what the state says.
struct Measurement {
  base::SmallView h, noise, innovation;
};

/// As TakeIn, sizes unchecked.
void TakeInto(const Measurement& measured, Eigen::Map<Eigen::MatrixXd> covariance,
              Eigen::Map<Eigen::VectorXd> step);

/// Takes a measurement into the covariance P of a state x, and returns the step of the state: with the gain
/// K = P Hᵀ (H P Hᵀ + R)⁻¹ the step is K times the innovation, and P becomes (1 - K H) P (1 - K H)ᵀ + K R Kᵀ
/// (Joseph's form, which stays symmetric and positive). No heap.
template <int kMeasured, int kState>
Eigen::Matrix<double, kState, 1> TakeIn(const Eigen::Matrix<double, kMeasured, kState>& h,
                                        const Eigen::Matrix<double, kMeasured, kMeasured>& noise,
                                        const Eigen::Matrix<double, kMeasured, 1>& innovation,
                                        Eigen::Matrix<double, kState, kState>& covariance) {
  Eigen::Matrix<double, kState, 1> step;
  TakeInto({base::ViewOf(h), base::ViewOf(noise), base::ViewOf(innovation)},
           {covariance.data(), kState, kState}, {step.data(), kState});
  return step;
}

}  // namespace adit::track
