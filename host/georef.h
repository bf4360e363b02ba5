// adit georef: the rig in the site grid.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds `adit georef --rig RIG --track T.csv|--recording REC --points P.csv|P.gsi --out GEOREF`.
void AddGeoref(CLI::App& app, int& exit_code);

}  // namespace adit::host
