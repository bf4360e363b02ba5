// A comparison of a track with the truth, as a page.
#pragma once

#include <string>

#include "host/comparison.h"
#include "host/report_page.h"

namespace adit::host {

/// Figures by target and distance; errors, stated against real errors, bar lengths, and the drive from above.
ReportPage MakeEvaluateReport(const Comparison& comparison, const std::string& track,
                              const std::string& truth);

}  // namespace adit::host
