#include "host/suites.h"

#include <algorithm>
#include <array>

#include "host/calibration_suite.h"
#include "host/failure.h"
#include "host/seed_suite.h"
#include "host/underground.h"
#include "host/watch_suite.h"

namespace adit::host {
namespace {

struct Suite {
  const char* name;
  int (*run)(const SuiteOrder&);
};

constexpr std::array kSuites{Suite{"seed", RunSeed}, Suite{"underground", RunUnderground},
                             Suite{"calibration", RunCalibrationSuite}, Suite{"watch", RunWatch}};

}  // namespace

std::vector<std::string> SuiteNames() {
  std::vector<std::string> names;
  for (const Suite& suite : kSuites) names.emplace_back(suite.name);
  return names;
}

int RunSuite(const SuiteOrder& order) {
  const auto suite = std::find_if(kSuites.begin(), kSuites.end(),
                                  [&order](const Suite& entry) { return entry.name == order.suite; });
  if (suite == kSuites.end()) {
    std::string allowed;
    for (const std::string& name : SuiteNames()) allowed += (allowed.empty() ? "" : ", ") + name;
    return Fail("evaluate",
                {base::ErrorCode::kUsage, "--suite", "is '" + order.suite + "'; allowed: " + allowed});
  }
  return suite->run(order);
}

}  // namespace adit::host
