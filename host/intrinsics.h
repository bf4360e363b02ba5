// adit intrinsics: a camera file from images of a calibration board.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddIntrinsics(CLI::App& app, int& exit_code);

}  // namespace adit::host
