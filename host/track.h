// adit track: a recording through the pipeline of the box, to a track file.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds the subcommand; its run sets `exit_code`.
void AddTrack(CLI::App& app, int& exit_code);

}  // namespace adit::host
