// What a campaign measured, beside its bars.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/report_page.h"

namespace adit::host {

/// One figure. `kNoBar` informs only.
struct SuiteFigure {
  enum class Bar : std::uint8_t { kAtMost, kAtLeast, kNoBar };

  std::string what, unit;
  double value = 0;
  Bar kind = Bar::kNoBar;
  double bar = 0;
  int decimals = 2;

  /// NaN (nothing was measured) holds no bar.
  bool Holds() const { return kind == Bar::kNoBar || (kind == Bar::kAtMost ? value <= bar : value >= bar); }
};

/// One case of a suite.
struct SuiteReport {
  std::string name;
  std::string how;  ///< what was done: counts, what was rendered
  std::vector<SuiteFigure> figures;
  std::vector<std::string> findings;  ///< the first things that went wrong, to be looked at

  void AtMost(std::string what, double value, double bar, std::string unit = "", int decimals = 2);
  void AtLeast(std::string what, double value, double bar, std::string unit = "", int decimals = 2);
  void Inform(std::string what, double value, std::string unit = "", int decimals = 2);
  bool Holds() const;
};

/// For people, and for machines.
std::string FormatSuiteTable(const SuiteReport& report);
std::string FormatSuiteJson(const std::vector<SuiteReport>& reports, const std::string& suite,
                            std::uint64_t seed);
/// A table a case; `caveat` says what the simulation leaves out. The verdict names the bars that are missed.
ReportPage MakeSuitePage(const std::vector<SuiteReport>& reports, const std::string& origin,
                         const std::string& caveat);

}  // namespace adit::host
