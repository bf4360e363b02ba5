#include "host/watch_suite.h"

#include <array>

namespace adit::host {
namespace {

constexpr std::array kWatchCases{SuiteCase{"step", MeasureStep}, SuiteCase{"quiet", MeasureQuiet},
                                 SuiteCase{"drift", MeasureDrift}};

}  // namespace

int RunWatch(const SuiteOrder& order) {
  return RunCases(kWatchCases, order,
                  "Simulated centroids at their bound and a phase bias. A tunnel adds moving air, and mounts "
                  "that creep.");
}

}  // namespace adit::host
