#include "host/underground.h"

#include <array>

#include "host/underground_cases.h"

namespace adit::host {
namespace {

constexpr std::array kUnderground{
    SuiteCase{"swaps", MeasureSwaps},         SuiteCase{"lamps", MeasureLamps},
    SuiteCase{"mirror", MeasureMirror},       SuiteCase{"fog", MeasureFog},
    SuiteCase{"drive", MeasureDrive},         SuiteCase{"vibration", MeasureVibration},
    SuiteCase{"ellipsoid", MeasureEllipsoid}, SuiteCase{"static", MeasureStatic},
    SuiteCase{"fifteen", MeasureFifteen}};

}  // namespace

int RunUnderground(const SuiteOrder& order) {
  return RunCases(kUnderground, order,
                  "Simulation: known lenses, no air turbulence, no dirt. A tunnel adds both.");
}

}  // namespace adit::host
