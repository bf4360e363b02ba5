// The image pairs that the speed is measured on: two bars among saturated discs, as many as the scenario
// says.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace adit::bench {

/// Two images of 1400 x 1024 px, 8 bit.
struct ImagePair {
  std::vector<std::uint8_t> left, right;
  base::CameraFrame Frame(base::Side side, base::TimeNs time_ns) const;
};

/// What all pairs show.
struct Stage {
  optics::Rig rig;
  std::vector<identify::Model> models;  ///< of the two bars
};
Stage MakeStage();

inline constexpr int kWidthPx = 1400, kHeightPx = 1024;

/// `count` different pairs: background 6 DN with noise of 1.7 DN, eight LEDs of sigma 1.2 to 2.5 px and 214
/// DN, and `lamps` discs at full scale in each image with radii of 2 to 30 px, as lamps near the camera are.
std::vector<ImagePair> RenderPairs(int count, int lamps, unsigned seed);

}  // namespace adit::bench
