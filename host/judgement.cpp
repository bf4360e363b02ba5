#include "host/judgement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace adit::host {
namespace {

using base::kLedCount;
using Eigen::Vector3d;
using Leds = std::array<Vector3d, kLedCount>;

double LedsApart(const Leds& a, const Leds& b) {
  double sum_m = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) sum_m += (a[i] - b[i]).norm();
  return sum_m;
}

}  // namespace

Judgement Judge(const stereo::TargetPoints& reported, const sim::TargetTruth& own,
                std::span<const sim::TargetTruth> all) {
  Judgement judgement;
  if (reported.status == stereo::FixStatus::kLost) return judgement;
  const Vector3d error_m = reported.epicenter_b_m - own.epicenter_m;
  judgement.error_m = error_m.norm();
  judgement.nees = error_m.dot(reported.epicenter_covariance_m2.ldlt().solve(error_m));
  const Vector3d along = error_m.normalized();
  const double sigma_m = std::sqrt(along.dot(reported.epicenter_covariance_m2 * along));
  // Written so that NaN is off.
  judgement.outcome =
      judgement.error_m <= kOffSigmas * sigma_m + kOffFloorM ? Outcome::kFound : Outcome::kOff;
  const double own_m = LedsApart(reported.leds_b_m, own.leds_m);
  Leds reversed = own.leds_m;
  std::reverse(reversed.begin(), reversed.end());
  bool swapped = LedsApart(reported.leds_b_m, reversed) < own_m;
  for (const sim::TargetTruth& other : all)
    swapped = swapped || LedsApart(reported.leds_b_m, other.leds_m) < own_m;
  if (swapped) judgement.outcome = Outcome::kSwapped;
  return judgement;
}

}  // namespace adit::host
