#include "host/calibration_suite.h"

#include <algorithm>
#include <array>
#include <iostream>

#include "drivers/linux/atomic_file.h"
#include "host/failure.h"

namespace adit::host {
namespace {

struct Case {
  const char* name;
  SuiteReport (*measure)(const CalibrationCount&);
};

constexpr std::array kCases{Case{"pose", MeasurePose}, Case{"intrinsics", MeasureRefined},
                            Case{"table52", MeasureTable52}, Case{"table54", MeasureTable54}};

}  // namespace

int RunCalibrationSuite(const SuiteOrder& order) {
  const auto wanted = [&order](const Case& entry) { return order.only.empty() || order.only == entry.name; };
  if (std::none_of(kCases.begin(), kCases.end(), wanted)) {
    return Fail("evaluate", {base::ErrorCode::kUsage, "--case",
                             "is '" + order.only + "'; allowed: pose, intrinsics, table52, table54"});
  }
  std::vector<SuiteReport> reports;
  CalibrationCount count;
  count.seed = order.seed;
  if (order.count > 0) count.count = order.count;
  for (const Case& entry : kCases) {
    if (!wanted(entry)) continue;
    reports.push_back(entry.measure(count));
    reports.back().name = entry.name;
    std::cout << FormatSuiteTable(reports.back()) << std::flush;
  }
  std::cout
      << "Simulated centroids: independent noise, a lens that the model describes. A tunnel is neither.\n";
  if (!order.json.empty()) {
    const std::string json = FormatSuiteJson(reports, order.suite, order.seed);
    if (auto written = linux::WriteFileAtomically(order.json, json); !written)
      return Fail("evaluate", written.error());
  }
  return std::all_of(reports.begin(), reports.end(), [](const SuiteReport& r) { return r.Holds(); }) ? 0 : 1;
}

}  // namespace adit::host
