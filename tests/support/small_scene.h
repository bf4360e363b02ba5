// Scenes for tests: a small rig, and whatever the test adds.
#pragma once

#include <cstdlib>
#include <iostream>
#include <string>

#include "drivers/sim/scene.h"
#include "tests/support/scratch_folder.h"

namespace adit::tests {

/// 320 x 240 px, f = 800 px, no distortion, baseline 1 m, both cameras look at (0.5, 0, 20) of the middle.
inline const std::string kSmallRig =
    "rig: {base_m: 1, focal_px: 800, width_px: 320, height_px: 240, converge_m: 20}\n";

/// A bar whose LEDs, at 20 m across the view, stand 16, 24 and 40 px apart, with a radius of 0.48 px.
inline const std::string kBarBuild = "name: bar, leds_m: [0, 0.4, 1, 2], led_diameter_m: 0.024";
inline const std::string kBarKeys = kBarBuild + ", peak_dn: 120, reference_m: 20";

inline base::Result<sim::Scene> TryScene(const std::string& text) {
  const ScratchFolder scratch;
  return sim::LoadScene(scratch.Write("scene.yaml", text));
}

/// Ends the program with the error if the scene is wrong: a mistake of the test.
inline sim::Scene SceneOf(const std::string& text) {
  auto scene = TryScene(text);
  if (!scene) {
    std::cerr << scene.error().Line() << "\n";
    std::abort();
  }
  return std::move(*scene);
}

}  // namespace adit::tests
