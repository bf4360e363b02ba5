// adit inspect: why a pair of a recording gave what it gave, as a picture.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddInspect(CLI::App& app, int& exit_code);

}  // namespace adit::host
