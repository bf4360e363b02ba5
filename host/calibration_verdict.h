// How good a calibration is, and whether it may be used.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "host/calibration.h"
#include "host/calibration_fit.h"

namespace adit::host {

/// Share of 8 x 6 cells of one image in which an LED was seen.
double CoveragePct(std::span<const StereoBar> bars, const optics::CameraModel& camera,
                   BarView StereoBar::*side);

/// The calibration that a fit stands for, measured on the bars used and the ones held out, without verdict.
/// `fit` has a covariance.
Calibration Conclude(const CalibrationInput& input, const CalibrationFit& fit,
                     std::span<const StereoBar> held_out);

/// Why it must not be used, with the remedy; empty if it may.
std::string Refuses(const Calibration& calibration);

/// What stands against calling it good, each with the remedy.
std::vector<std::string> Reservations(const Calibration& calibration);

}  // namespace adit::host
