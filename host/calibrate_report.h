// A calibration, as a page: the bars looked at again with the finished rig.
#pragma once

#include "host/calibration.h"
#include "host/report_page.h"

namespace adit::host {

/// The bars used are fitted rigidly (stereo::FitBar) with the finished rig, apart from the adjustment; those
/// that miss by more than 31 in chi-square (99.9 % of 11 degrees of freedom) stand in no plot. Figures, the
/// lenses beside their files, what to expect at 30, 70 and 110 m, coverage and residual vectors of both
/// images, bar length against distance beside its stated sigma, held-out bars beside what was predicted of
/// them, the places from above, the wrong pairs.
ReportPage MakeCalibrateReport(const CalibrationInput& input, const Calibration& calibration);

}  // namespace adit::host
