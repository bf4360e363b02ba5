// A machine that carries two bars or more.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/pose.h"
#include "firmware/base/result.h"
#include "firmware/base/target.h"

namespace adit::track {

inline constexpr std::size_t kMaxBodyBars = 8;

/// One bar in the body's frame t.
struct BodyBar {
  std::uint8_t target = 0;                             ///< index into the model list
  Eigen::Vector3d led1_t_m = Eigen::Vector3d::Zero();  ///< place of LED 1
  Eigen::Vector3d direction_t = Eigen::Vector3d::UnitX();
  double centre_m = 0;  ///< along the bar from LED 1
  double length_m = 1;

  Eigen::Vector3d CentreM() const { return led1_t_m + centre_m * direction_t; }
};

/// A rigid body: where its bars are.
struct Body {
  std::string name;
  double sigma_m = 0.001;  ///< of the places of a bar's ends, one standard deviation in each axis
  base::FixedVector<BodyBar, kMaxBodyBars> bars;

  /// The mean of the bars' centres, where place and turns hardly depend on each other.
  Eigen::Vector3d MiddleM() const;
};

/// Reads a body file: `name`, optional `sigma_m`, and `targets`, each with `name` (of one of `targets`),
/// `at_m` (LED 1) and `direction` (to LED 4) in the body's frame. Refuses fewer than two bars or more than
/// kMaxBodyBars, targets that are not known or stand twice, a direction without length, and bars that all lie
/// on one line, which show nothing of the turn around it. Errors name file, key, value and what is allowed.
base::Result<Body> LoadBody(const std::string& path, const std::vector<base::Target>& targets);

/// Reads them in order. Refuses also two of one name, one named as a target, and more than `at_most`.
base::Result<std::vector<Body>> LoadBodies(const std::vector<std::string>& paths,
                                           const std::vector<base::Target>& targets, std::size_t at_most);

}  // namespace adit::track
