// adit serve: a scene as two GigE Vision cameras.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds `adit serve SCENE --left IP --right IP [--truth FILE] [--seconds N]`; its run sets `exit_code`.
void AddServe(CLI::App& app, int& exit_code);

}  // namespace adit::host
