// adit calibrate: a rig file from recordings of a waved bar.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddCalibrate(CLI::App& app, int& exit_code);

}  // namespace adit::host
