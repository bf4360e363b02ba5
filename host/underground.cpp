#include "host/underground.h"

#include <algorithm>
#include <array>
#include <iostream>

#include "drivers/linux/atomic_file.h"
#include "drivers/sim/random.h"
#include "host/failure.h"
#include "host/underground_cases.h"

namespace adit::host {
namespace {

struct Case {
  const char* name;
  SuiteReport (*measure)(const CaseOrder&);
};

constexpr std::array kCases{Case{"swaps", MeasureSwaps},         Case{"lamps", MeasureLamps},
                            Case{"mirror", MeasureMirror},       Case{"fog", MeasureFog},
                            Case{"drive", MeasureDrive},         Case{"vibration", MeasureVibration},
                            Case{"ellipsoid", MeasureEllipsoid}, Case{"static", MeasureStatic},
                            Case{"fifteen", MeasureFifteen}};

base::Error NoSuchCase(const std::string& name) {
  std::string allowed;
  for (const Case& entry : kCases) allowed += std::string(allowed.empty() ? "" : ", ") + entry.name;
  return {base::ErrorCode::kUsage, "--case", "is '" + name + "'; allowed: " + allowed};
}

}  // namespace

std::uint64_t PieceSeed(const CaseOrder& order, std::size_t index) {
  return sim::Random(order.seed, index).Next();
}

int RunUnderground(const SuiteOrder& order) {
  const auto wanted = [&order](const Case& entry) { return order.only.empty() || order.only == entry.name; };
  if (std::none_of(kCases.begin(), kCases.end(), wanted)) return Fail("evaluate", NoSuchCase(order.only));
  std::vector<SuiteReport> reports;
  for (const Case& entry : kCases) {
    if (!wanted(entry)) continue;
    reports.push_back(entry.measure({order.count, order.seed}));
    reports.back().name = entry.name;
    std::cout << FormatSuiteTable(reports.back()) << std::flush;
  }
  std::cout << "Simulation: known lenses, no air turbulence, no dirt. A tunnel adds both.\n";
  if (!order.json.empty()) {
    const std::string json = FormatSuiteJson(reports, order.suite, order.seed);
    if (auto written = linux::WriteFileAtomically(order.json, json); !written)
      return Fail("evaluate", written.error());
  }
  const bool holds =
      std::all_of(reports.begin(), reports.end(), [](const SuiteReport& r) { return r.Holds(); });
  return holds ? 0 : 1;
}

}  // namespace adit::host
