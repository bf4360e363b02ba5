// An intrinsic calibration as people and programs read it.
#pragma once

#include <string>

#include "host/board.h"
#include "host/intrinsic_calibration.h"

namespace adit::host {

/// The camera file: EuRoC sensor.yaml with adit's keys, which other readers skip. `sigma` and `covariance`
/// are of fu, fv, cu, cv (px), k1, k2, p1, p2; `quality` says how it came about.
std::string FormatIntrinsics(const IntrinsicCalibration& calibration);

/// Images with their residuals, parameters beside OpenCV's, coverage and verdict, for a terminal.
std::string Summary(const IntrinsicCalibration& calibration, const Board& board);

}  // namespace adit::host
