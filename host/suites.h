// adit evaluate --suite: campaigns that measure adit against its bars.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace adit::host {

/// What a campaign is asked for.
struct SuiteOrder {
  std::string suite;
  std::string only;        ///< one case of it; empty: all
  std::size_t count = 0;   ///< of what the case counts; 0: few enough for seconds
  std::uint64_t seed = 1;  ///< all that is random
  std::string json;        ///< file for the figures; empty: none
  std::string report;      ///< file for the page; empty: none
};

/// The names of the suites, in the order of the help.
std::vector<std::string> SuiteNames();

/// Runs the campaign and prints every figure beside its bar. Returns the exit code: 0 all bars hold, 1 one is
/// missed or a file cannot be written, 2 there is no such suite or case.
int RunSuite(const SuiteOrder& order);

}  // namespace adit::host
