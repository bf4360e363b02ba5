// adit config: checks, explains and shows a box's configuration.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds `adit config check|schema|show FILE`. `check` also reads the rig and the models that the file names.
void AddConfig(CLI::App& app, int& exit_code);

}  // namespace adit::host
