// How well an adjusted bundle knows its cameras.
#pragma once

#include <optional>

#include "host/bundle.h"

namespace adit::host {

/// The cameras' block of the inverse normal matrix at `state`: Schur complement of every bar and point,
/// priors added, bar lengths marginalised, times their units. Ceres' own Covariance factors the whole
/// Jacobian, which takes longer than the adjustment. Empty if the data leave a direction free.
std::optional<optics::RigCovariance> BundleCovariance(const BundleSetting& setting, const BundleData& data,
                                                      const BundleState& state);

}  // namespace adit::host
