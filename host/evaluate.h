// adit evaluate: a track against the truth.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddEvaluate(CLI::App& app, int& exit_code);

}  // namespace adit::host
