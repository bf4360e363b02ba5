// adit demo: the main job at work on this machine.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds `adit demo [--seconds N] [--scene FILE] [--out FOLDER]`. Run it in a network namespace of its own
/// (./run demo does).
void AddDemo(CLI::App& app, int& exit_code);

}  // namespace adit::host
