// The parts of a scene file that several of its keys share. For scene.cpp and its neighbours.
#pragma once

#include <string>

#include "drivers/sim/scene.h"
#include "firmware/base/yaml.h"

namespace adit::sim {

inline constexpr base::Range kSomewhereM{-2000, 2000};  ///< a tunnel ends before
inline constexpr base::Range kTimeS{-1e6, 1e6};

Eigen::Vector3d ReadVector(base::YamlReader& in, const std::string& key);
Eigen::Vector3d ReadVectorOr(base::YamlReader& in, const std::string& key, const Eigen::Vector3d& fallback);
/// A unit vector of any given length but 0.
Eigen::Vector3d ReadDirection(base::YamlReader& in, const std::string& key);
std::vector<Interval> ReadIntervals(base::YamlReader& in, const std::string& key);

/// `path`, `drive` or `at_m`. Never null.
MotionPtr ReadMotion(base::YamlReader& in, const base::Pose<base::Rig, Ground>& T_b_g);
/// A motion that is the ground frame itself.
MotionPtr GroundMotion(const base::Pose<base::Rig, Ground>& T_b_g);

/// `file` or the target's own keys; `scene_path` is where a relative file starts from.
base::Target ReadTarget(base::YamlReader& in, const std::string& scene_path);
/// `rig_file` or `rig`.
optics::Rig ReadRig(base::YamlReader& in, const std::string& scene_path);

}  // namespace adit::sim
