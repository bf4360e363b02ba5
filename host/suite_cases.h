// The loop over the cases of a suite: which are wanted, their tables, their figures as JSON.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/suite_report.h"
#include "host/suites.h"

namespace adit::host {

/// How much of a case is wanted.
struct CaseOrder {
  std::size_t count = 0;  ///< 0: as the case sees fit
  std::uint64_t seed = 1;

  std::size_t CountOr(std::size_t fitting) const { return count == 0 ? fitting : count; }
};

/// The seed of the piece `index` of a case.
std::uint64_t PieceSeed(const CaseOrder& order, std::size_t index);

struct SuiteCase {
  const char* name;
  SuiteReport (*measure)(const CaseOrder&);
};

/// Measures the cases that `order` names, prints each as it is done and `caveat` after them, and writes the
/// JSON and the page if they are asked for. Returns the exit code as RunSuite does.
int RunCases(std::span<const SuiteCase> cases, const SuiteOrder& order, const std::string& caveat);

}  // namespace adit::host
