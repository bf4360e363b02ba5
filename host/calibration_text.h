// A calibration as people and programs read it.
#pragma once

#include <string>

#include "host/calibration.h"

namespace adit::host {

/// The rig file: Kalibr camchain with adit's keys. `calibration_id` is the CRC-32 of the cameras and the
/// pose, so that equal calibrations have equal names; `time` is that of the newest bar (UTC). `covariance` is
/// 6 x 6 of (rotation vector in the right camera's frame, rad; translation, m); `quality` says how it came
/// about.
std::string FormatCalibration(const Calibration& calibration);

/// What a person wants to know of it, a few lines.
std::string Summary(const CalibrationQuality& quality);

}  // namespace adit::host
