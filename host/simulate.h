// adit simulate: a recording with truth from a described scene.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/base/result.h"

namespace adit::host {

struct SimulateOrder {
  std::string scene;  ///< file, see drivers/sim/scene.h
  std::string out;    ///< folder; must not exist, or be empty
  std::optional<long> frames;
  std::optional<std::uint64_t> seed;
};

/// Renders the scene into `out`: cam0 and cam1 in EuRoC layout, truth.csv, the true rig as rig_true.yaml, and
/// each target as target_<name>.yaml. One thread a camera. All is written into a folder beside `out` that
/// takes its name at the end: after a failure there is no `out`. The same order gives the same bytes.
base::Result<void> Simulate(const SimulateOrder& order);

/// Adds `adit simulate SCENE.yaml --out REC [--frames N] [--seed S]`.
void AddSimulate(CLI::App& app, int& exit_code);

}  // namespace adit::host
