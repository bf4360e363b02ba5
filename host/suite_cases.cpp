#include "host/suite_cases.h"

#include <algorithm>
#include <iostream>
#include <utility>
#include <vector>

#include "drivers/sim/random.h"
#include "host/failure.h"

namespace adit::host {
namespace {

base::Error NoSuchCase(std::span<const SuiteCase> cases, const std::string& name) {
  std::string allowed;
  for (const SuiteCase& entry : cases) allowed += std::string(allowed.empty() ? "" : ", ") + entry.name;
  return {base::ErrorCode::kUsage, "--case", "is '" + name + "'; allowed: " + allowed};
}

}  // namespace

std::uint64_t PieceSeed(const CaseOrder& order, std::size_t index) {
  return sim::Random(order.seed, index).Next();
}

int RunCases(std::span<const SuiteCase> cases, const SuiteOrder& order, const std::string& caveat) {
  const auto wanted = [&order](const SuiteCase& entry) {
    return order.only.empty() || order.only == entry.name;
  };
  if (std::none_of(cases.begin(), cases.end(), wanted))
    return Fail("evaluate", NoSuchCase(cases, order.only));
  std::vector<SuiteReport> reports;
  for (const SuiteCase& entry : cases) {
    if (!wanted(entry)) continue;
    reports.push_back(entry.measure({order.count, order.seed}));
    reports.back().name = entry.name;
    std::cout << FormatSuiteTable(reports.back()) << std::flush;
  }
  std::cout << caveat << "\n";
  std::vector<linux::FileText> figures;
  if (!order.json.empty()) figures.push_back({order.json, FormatSuiteJson(reports, order.suite, order.seed)});
  const std::string origin = "suite " + order.suite + ", seed " + std::to_string(order.seed);
  if (auto written =
          WriteReport(MakeSuitePage(reports, origin, caveat), {order.report, ""}, std::move(figures));
      !written)
    return Fail("evaluate", written.error());
  const bool holds =
      std::all_of(reports.begin(), reports.end(), [](const SuiteReport& r) { return r.Holds(); });
  return holds ? 0 : 1;
}

}  // namespace adit::host
