// adit evaluate --suite seed
#pragma once

#include "host/suites.h"

namespace adit::host {

/// Measures and prints the tables; `count` is the calibrations of each rig, `only` a table's number. Returns
/// the exit code.
int RunSeed(const SuiteOrder& order);

}  // namespace adit::host
