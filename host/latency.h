// adit latency: where the time between light and machine goes, told by a running box.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "firmware/publish/health_report.h"

namespace adit::host {

/// One row per part of the way, in microseconds. The part within Aravis has a row of its own.
std::string FormatLatency(const publish::HealthReport& report);

/// Adds `adit latency BOX.yaml`, on the machine of the box.
void AddLatency(CLI::App& app, int& exit_code);

}  // namespace adit::host
