// LEDs that are hidden, lights beside them, and where a bar is expected.
#pragma once

#include "firmware/stereo/expectation.h"
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

/// What the tracking would say of a bar that it knows to `sigma_m` in each end.
inline stereo::Expectation Expect(const support::SyntheticBar& bar, double sigma_m) {
  stereo::Expectation expected;
  expected.known = true;
  expected.led1_b_m = bar.led1_b_m;
  expected.direction_b = bar.direction_b;
  const double length_m = bar.target.LengthM();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - bar.direction_b * bar.direction_b.transpose();
  expected.covariance.topLeftCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  expected.covariance.bottomRightCorner<3, 3>() = sigma_m * sigma_m / (length_m * length_m) * across;
  return expected;
}

}  // namespace adit::stereo_tests
