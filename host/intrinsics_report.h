// A camera's intrinsics, as a page.
#pragma once

#include "host/board.h"
#include "host/intrinsic_calibration.h"
#include "host/report_page.h"

namespace adit::host {

/// Parameters with sigmas beside OpenCV's, images with their residuals, coverage and residual vectors.
ReportPage MakeIntrinsicsReport(const IntrinsicCalibration& calibration, const Board& board);

}  // namespace adit::host
