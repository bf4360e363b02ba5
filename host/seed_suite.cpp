#include "host/seed_suite.h"

#include <algorithm>
#include <iostream>

#include "host/failure.h"
#include "host/seed_tables.h"

namespace adit::host {

int RunSeed(const SuiteOrder& order) {
  SeedOrder seed;
  if (order.count > 0) seed.calibrations = order.count;
  seed.seed = order.seed, seed.only = order.only;
  const auto numbers = SeedTableNumbers();
  if (!seed.only.empty() && std::find(numbers.begin(), numbers.end(), seed.only) == numbers.end()) {
    std::string allowed;
    for (const std::string& number : numbers) allowed += (allowed.empty() ? "" : ", ") + number;
    return Fail("evaluate",
                {base::ErrorCode::kUsage, "--case", "is '" + seed.only + "'; allowed: " + allowed});
  }
  const auto tables = MeasureSeedTables(seed);
  if (!tables) return Fail("evaluate", tables.error());
  for (const SeedTable& table : *tables) std::cout << FormatSeedTable(table) << "\n";
  for (const std::string& caveat : SeedCaveats(seed)) std::cout << caveat << "\n";
  if (auto written = WriteReport(MakeSeedReport(*tables, seed), {order.report, order.json}); !written)
    return Fail("evaluate", written.error());
  return std::all_of(tables->begin(), tables->end(), [](const SeedTable& table) { return table.Holds(); })
             ? 0
             : 1;
}

}  // namespace adit::host
