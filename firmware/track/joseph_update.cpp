#include "firmware/track/joseph_update.h"

namespace adit::track {

using base::SmallMatrix;

// lazyProduct everywhere: for factors this small Eigen's blocked product costs more than it saves.
void TakeInto(const Measurement& measured, Eigen::Map<Eigen::MatrixXd> covariance,
              Eigen::Map<Eigen::VectorXd> step) {
  const auto& [h, noise, innovation] = measured;
  const auto size = [](const SmallMatrix& m) { return base::SmallView(m.data(), m.rows(), m.cols()); };
  const SmallMatrix h_p = h.lazyProduct(covariance);
  const SmallMatrix s = h_p.lazyProduct(h.transpose()) + noise;
  SmallMatrix gain_transposed(h.rows(), h.cols());
  base::SolveInto(size(s), size(h_p), {gain_transposed.data(), h.rows(), h.cols()});
  const SmallMatrix gain = gain_transposed.transpose();
  step = gain.lazyProduct(innovation);
  const SmallMatrix left = SmallMatrix::Identity(h.cols(), h.cols()) - gain.lazyProduct(h);
  SmallMatrix kept(h.cols(), h.cols()), added(h.cols(), h.cols());
  base::CongruenceInto(size(left), {covariance.data(), h.cols(), h.cols()},
                       {kept.data(), h.cols(), h.cols()});
  base::CongruenceInto(size(gain), noise, {added.data(), h.cols(), h.cols()});
  kept += added;
  covariance = 0.5 * (kept + kept.transpose());
}

}  // namespace adit::track
