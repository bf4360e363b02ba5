// adit diff: two tracks of one recording, compared.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`: 0 the same, 1 different beyond the tolerance.
void AddDiff(CLI::App& app, int& exit_code);

}  // namespace adit::host
