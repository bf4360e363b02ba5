// A trained target: what the identification may accept.
#pragma once

#include <string>

#include "firmware/base/result.h"
#include "firmware/base/target.h"

namespace adit::identify {

/// The trained model of a target (seed 4.3.4.2).
struct Model {
  base::Target target;
  double p2_min = 0, p2_max = 0;  ///< range of the p2 invariant, within [2, 2.8]
  double collinearity_max = 0;    ///< largest rms distance from the common line, divided by the length in px
  double length_min_px = 0, length_max_px = 0;  ///< LED 1 to LED 4 in the image
  std::string trained_on;                       ///< recordings, or "geometry"
};

/// Reads a target file; refuses other than four LEDs, ones not ascending from 0, gaps below 10 mm, and
/// layouts symmetric within 1 % (their direction cannot be told).
base::Result<base::Target> LoadTarget(const std::string& path);
std::string FormatTarget(const base::Target& target);

/// Reads a model file: the target's keys and the trained ranges.
base::Result<Model> LoadModel(const std::string& path);
std::string FormatModel(const Model& model);

}  // namespace adit::identify
