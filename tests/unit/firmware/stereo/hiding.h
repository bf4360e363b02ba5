// LEDs that are hidden, and lights beside them.
#pragma once

#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace adit::stereo_tests {

inline constexpr unsigned kLeft = 1, kRight = 2, kBoth = 3;

/// Removes blob `index` from the images named.
inline void Hide(support::BlobPair& blobs, std::size_t index, unsigned images) {
  const auto remove = [index](detect::BlobSet& set) {
    for (std::size_t i = index; i + 1 < set.blobs.size(); ++i) set.blobs[i] = set.blobs[i + 1];
    set.blobs.Truncate(set.blobs.size() - 1);
  };
  if ((images & kLeft) != 0) remove(blobs.left);
  if ((images & kRight) != 0) remove(blobs.right);
}

/// Adds a light of an LED's brightness on the bar's line, `place_m` from LED 1.
inline void AddLightInLine(support::SyntheticScene& scene, const support::SyntheticBar& bar, double place_m) {
  auto light = bar;
  light.target.leds_m.fill(place_m);
  CHECK(scene.AddBar(light, 0.02));
  for (auto* set : {&scene.Blobs().left, &scene.Blobs().right}) set->blobs.Truncate(set->blobs.size() - 3);
}

/// Leaves a region where blob `index` of an image is, as one does that merged with a lamp.
inline void Obscure(detect::BlobSet& set, std::size_t index) {
  const Eigen::Vector2i px = set.blobs[index].raw_px.cast<int>();
  set.regions.push_back({px.x() - 3, px.y() - 9, px.x() + 3, px.y() + 3});
}

}  // namespace adit::stereo_tests
