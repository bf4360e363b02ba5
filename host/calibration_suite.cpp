#include "host/calibration_suite.h"

#include <array>

namespace adit::host {
namespace {

constexpr std::array kCalibrations{SuiteCase{"pose", MeasurePose}, SuiteCase{"intrinsics", MeasureRefined},
                                   SuiteCase{"table52", MeasureTable52},
                                   SuiteCase{"table54", MeasureTable54}};

}  // namespace

int RunCalibrationSuite(const SuiteOrder& order) {
  return RunCases(
      kCalibrations, order,
      "Simulated centroids: independent noise, a lens that the model describes. A tunnel is neither.");
}

}  // namespace adit::host
