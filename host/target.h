// adit target: line targets, designed.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddTarget(CLI::App& app, int& exit_code);

}  // namespace adit::host
