// The Cramer-Rao bound of a calibration: what its bars can tell at best, whoever computes it.
#pragma once

#include <optional>

#include "host/simulated_calibration.h"

namespace adit::host {

/// The smallest covariance of the rig's parameters for the draw's bars, priors and noise (Fisher information
/// by numeric derivatives of the true projection, bars and the bar's length eliminated; Bayesian where there
/// is a prior: Van Trees 1968). Shares nothing with the bundle adjustment. Empty if the bars leave a
/// direction free.
std::optional<optics::RigCovariance> CalibrationBound(const CalibrationPlan& plan,
                                                      const CalibrationDraw& draw);

/// The smallest standard deviation of LED 1 to LED 4 for centroids of `noise_px`, the rig known.
double LengthBound(const CalibrationPlan& plan, const TrueRig& rig, const TrueBar& bar);

}  // namespace adit::host
