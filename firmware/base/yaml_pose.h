// Poses in YAML files.
#pragma once

#include <string>

#include "firmware/base/pose.h"
#include "firmware/base/yaml.h"

namespace adit::base {

/// Reads the 4 rows of 4 numbers below `key` into `rotation` and `translation_m`. Refuses a last row other
/// than [0, 0, 0, 1], a mirror, and a rotation whose R R^T differs from 1 by more than 1e-6; then both stay
/// as they are.
void ReadRigidMotion(YamlReader& in, const std::string& key, Eigen::Matrix3d& rotation,
                     Eigen::Vector3d& translation_m);

/// A rigid motion as a pose; the identity after a mistake.
template <class To, class From>
Pose<To, From> ReadPose(YamlReader& in, const std::string& key) {
  Pose<To, From> pose;
  ReadRigidMotion(in, key, pose.rotation, pose.translation_m);
  return pose;
}

/// Reads the 6 rows of 6 numbers below `key`. Refuses what is not symmetric or gives some combination of its
/// parameters a negative variance.
void ReadCovariance(YamlReader& in, const std::string& key, Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace adit::base
