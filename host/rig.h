// adit rig: what an operator does with a rig file.
#pragma once

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <string>

#include "firmware/base/result.h"

namespace adit::host {

/// A turn of the right camera as aditd reports it: rotation vector in its own frame, about its projection
/// centre.
struct CameraTurn {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();
};

/// The turn that a box's health report states of the calibration `calibration_id`. Declines reports without
/// a watch or of another calibration, and what the box does not hold for a turn.
base::Result<CameraTurn> LoadTurn(const std::string& health_path, const std::string& calibration_id);

/// The rig file of `path` with the turn applied, R' = Exp(turn) R and t' = Exp(turn) t, as text: new
/// calibration id, covariance grown by the turn's (if the file has one), `quality` names the calibration that
/// it comes from. Refuses turns beyond what the watch can tell, and sigmas that are not positive.
base::Result<std::string> CorrectedRig(const std::string& path, const CameraTurn& turn);

/// Adds `adit rig correct --rig RIG (--health REPORT | --turn-urad X,Y,Z --sigma-urad X,Y,Z) --out NEW`.
void AddRig(CLI::App& app, int& exit_code);

}  // namespace adit::host
