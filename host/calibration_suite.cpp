#include "host/calibration_suite.h"

#include <array>

namespace adit::host {
namespace {

constexpr std::array kCalibrations{
    SuiteCase{"pose", MeasurePose},       SuiteCase{"intrinsics", MeasureRefined},
    SuiteCase{"table52", MeasureTable52}, SuiteCase{"table54", MeasureTable54},
    SuiteCase{"clutter", MeasureClutter}, SuiteCase{"rendered", MeasureRendered}};

}  // namespace

int RunCalibrationSuite(const SuiteOrder& order) {
  return RunCases(
      kCalibrations, order,
      "Simulation: centroids with independent noise but for the rendered ones, a lens that the model "
      "describes. A tunnel has neither.");
}

}  // namespace adit::host
