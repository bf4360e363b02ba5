// A calibration as people and programs read it.
#pragma once

#include <string>

#include "host/calibration.h"

namespace adit::host {

/// The rig file: Kalibr camchain with adit's keys. `calibration_id` is the CRC-32 of the cameras and the
/// pose, so that equal calibrations have equal names; `time` is that of the newest bar (UTC). `covariance` is
/// optics::RigCovariance; `quality` says how it came about.
std::string FormatCalibration(const Calibration& calibration);

/// What a person wants to know of it, a few lines.
std::string Summary(const Calibration& calibration);
/// How many lights at rest were seen, and how many count; empty if none were asked for.
std::string LightsText(const Calibration& calibration, const CalibrationInput& input);
/// The pairs left out, each with recording, time, target and reason; the first dozen.
std::string WrongPairs(const Calibration& calibration, const CalibrationInput& input);
/// Good, or usable with the reservations.
std::string VerdictText(const Calibration& calibration);

}  // namespace adit::host
