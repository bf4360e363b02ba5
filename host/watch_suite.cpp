#include "host/watch_suite.h"

#include <algorithm>
#include <array>
#include <iostream>

#include "drivers/linux/atomic_file.h"
#include "host/failure.h"

namespace adit::host {
namespace {

struct WatchCase {
  const char* name;
  SuiteReport (*measure)(const CaseOrder&);
};

constexpr std::array kWatchCases{WatchCase{"step", MeasureStep}, WatchCase{"quiet", MeasureQuiet},
                                 WatchCase{"drift", MeasureDrift}};

}  // namespace

int RunWatch(const SuiteOrder& order) {
  const auto wanted = [&order](const WatchCase& entry) {
    return order.only.empty() || order.only == entry.name;
  };
  if (std::none_of(kWatchCases.begin(), kWatchCases.end(), wanted)) {
    return Fail("evaluate",
                {base::ErrorCode::kUsage, "--case", "is '" + order.only + "'; allowed: step, quiet, drift"});
  }
  std::vector<SuiteReport> reports;
  for (const WatchCase& entry : kWatchCases) {
    if (!wanted(entry)) continue;
    reports.push_back(entry.measure({order.count, order.seed}));
    reports.back().name = entry.name;
    std::cout << FormatSuiteTable(reports.back()) << std::flush;
  }
  std::cout << "Simulated centroids, who is who known. A tunnel adds air, and mounts that creep.\n";
  if (!order.json.empty()) {
    const std::string json = FormatSuiteJson(reports, order.suite, order.seed);
    if (auto written = linux::WriteFileAtomically(order.json, json); !written)
      return Fail("evaluate", written.error());
  }
  return std::all_of(reports.begin(), reports.end(), [](const SuiteReport& r) { return r.Holds(); }) ? 0 : 1;
}

}  // namespace adit::host
