// What a calibration says of its own uncertainty.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "firmware/base/result.h"

namespace adit::optics {

/// Of (rotation vector in the right camera's frame, rad; translation of T_r_l, m).
using RigCovariance = Eigen::Matrix<double, 6, 6>;

/// Reads the key `covariance` of a rig file; nothing if it has none, as Kalibr's have not. Refuses one that
/// is not symmetric or has a negative variance.
base::Result<std::optional<RigCovariance>> LoadRigCovariance(const std::string& path);

/// The same as YAML text.
std::string FormatRigCovariance(const RigCovariance& covariance);

}  // namespace adit::optics
