// What a measurement leaves of a covariance.
#pragma once

#include <Eigen/Core>

namespace adit::track {

/// Takes a measurement into `covariance`, in Joseph's form P = (1 - K H) P (1 - K H)^T + K R K^T, which stays
/// symmetric and positive. `h` is H's part by the leading parameters of the state; its rest is zero. `gain`
/// is K and `noise` R. lazyProduct: for factors this small Eigen's blocked product costs more than it saves.
template <int kState, int kSeen, int kLeading>
void JosephUpdate(Eigen::Matrix<double, kState, kState>& covariance,
                  const Eigen::Matrix<double, kSeen, kLeading>& h,
                  const Eigen::Matrix<double, kState, kSeen>& gain,
                  const Eigen::Matrix<double, kSeen, kSeen>& noise) {
  const Eigen::Matrix<double, kSeen, kState> seen = h.lazyProduct(covariance.template topRows<kLeading>());
  covariance -= gain.lazyProduct(seen);
  const Eigen::Matrix<double, kState, kSeen> left =
      covariance.template leftCols<kLeading>().lazyProduct(h.transpose());
  const Eigen::Matrix<double, kState, kSeen> added = gain.lazyProduct(noise);
  covariance += (added - left).lazyProduct(gain.transpose());
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
}

}  // namespace adit::track
