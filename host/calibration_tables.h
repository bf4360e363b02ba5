// A calibration's figures and tables for its page and its JSON.
#pragma once

#include <vector>

#include "host/calibration.h"
#include "host/report_page.h"

namespace adit::host {

/// Bars, pose and residuals. Every frame and target with a candidate is adjusted, held out or a wrong pair.
std::vector<ReportFact> QualityFacts(const Calibration& calibration);

/// What the adjustment was free to refine, a row a parameter: its value and sigma, those of the camera file,
/// and the shift in the file's sigmas. No rows with exact files.
ReportTable IntrinsicTable(const CalibrationInput& input, const Calibration& calibration);

/// Straight ahead of the rig: one sigma of a point by the calibration, one LED's noise, and how far a turn in
/// yaw or a shift of the disparity moves it.
ReportTable PredictionTable(const CalibrationQuality& quality);

ReportTable GapTable(const std::vector<CoverageGap>& gaps);
ReportTable WrongPairTable(const CalibrationInput& input, const std::vector<WrongPair>& wrong);

}  // namespace adit::host
