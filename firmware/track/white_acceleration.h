// What white accelerations add to a covariance.
#pragma once

#include <Eigen/Core>

namespace adit::track {

/// The places that stand at `place` in the covariance, the rates that belong to them at `rate`.
struct PlaceAndRate {
  int place = 0, rate = 0, size = 3;
};

/// Carries `covariance` over `dt_s` of constant rates and adds the noise of accelerations of the power
/// `sigma`^2 (per Hz): q (dt^3/3, dt^2/2; dt^2/2, dt) to each pair (Bar-Shalom, Li, Kirubarajan 2001, 6.2.2).
template <int kSize>
void CarryOver(Eigen::Matrix<double, kSize, kSize>& covariance, const PlaceAndRate& of, double sigma,
               double dt_s) {
  const double power = sigma * sigma;
  for (int i = 0; i < of.size; ++i) {
    covariance.row(of.place + i) += dt_s * covariance.row(of.rate + i);
    covariance.col(of.place + i) += dt_s * covariance.col(of.rate + i);
  }
  for (int i = 0; i < of.size; ++i) {
    const int place = of.place + i, rate = of.rate + i;
    covariance(place, place) += power * dt_s * dt_s * dt_s / 3;
    covariance(place, rate) += power * dt_s * dt_s / 2;
    covariance(rate, place) += power * dt_s * dt_s / 2;
    covariance(rate, rate) += power * dt_s;
  }
}

}  // namespace adit::track
