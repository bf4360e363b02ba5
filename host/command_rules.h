// What holds for the options of every command.
#pragma once

#include <CLI/CLI.hpp>

namespace adit::host {

/// Adds to all commands below `app`, before they run: a number must be finite (CLI11's ranges let NaN
/// through, and a limit that is NaN refuses nothing), and no output (--out, --report, --json, --coverage) may
/// be a file that another option reads. Both end the parsing with CLI::ValidationError, which names the
/// option.
void AddCommandRules(CLI::App& app);

}  // namespace adit::host
