// adit train: a model from a target and, if given, recordings of it.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddTrain(CLI::App& app, int& exit_code);

}  // namespace adit::host
