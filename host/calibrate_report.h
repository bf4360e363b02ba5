// A calibration, as a page: the bars looked at again with the finished rig.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/optics/rig.h"
#include "host/coverage_gap.h"
#include "host/report_page.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// What the page is made of.
struct CalibrationPicture {
  std::string origin;  ///< recordings
  const optics::Rig& rig;
  const std::vector<base::Target>& targets;
  const std::vector<StereoBar>& bars;  ///< candidates, wrong pairs among them
  std::vector<ReportFact> facts;       ///< of the calibration's own quality
  std::vector<CoverageGap> gaps = {};  ///< where to wave next
  ReportVerdict verdict = ReportVerdict::kGood;
  std::vector<std::string> reservations = {};
};

/// Every candidate bar is fitted rigidly (stereo::FitBar): those that miss by more than 31 in chi-square
/// (99.9 % of 11 degrees of freedom) are told as wrong pairs and left out of the plots. Coverage and residual
/// vectors of both images, bar length against distance beside its stated sigma, and the places from above.
ReportPage MakeCalibrateReport(const CalibrationPicture& picture);

}  // namespace adit::host
