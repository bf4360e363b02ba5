// The image pairs that the speed is measured on: two bars among saturated discs, as many as the scenario
// says.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/linux/huge_memory.h"
#include "firmware/base/image.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace adit::bench {

inline constexpr int kWidthPx = 1400, kHeightPx = 1024;

/// One image, 8 bit, in memory as the cameras' buffers are.
struct Image {
  linux::HugeMemory memory;

  std::span<const std::uint8_t> Pixels() const {
    return {memory.get(), static_cast<std::size_t>(kWidthPx) * kHeightPx};
  }
};

struct ImagePair {
  Image left, right;
  base::CameraFrame Frame(base::Side side, base::TimeNs time_ns) const;
};

/// What all pairs show.
struct Stage {
  optics::Rig rig;
  std::vector<identify::Model> models;  ///< of the bars
};
Stage MakeStage(std::size_t targets);

/// `count` different pairs: background 6 DN with noise of 1.7 DN, eight LEDs of sigma 1.2 to 2.5 px and 214
/// DN, and `lamps` discs at full scale in each image with radii of 2 to 30 px, as lamps near the camera are.
std::vector<ImagePair> RenderPairs(int count, int lamps, unsigned seed);

/// The same with four bars that move a tenth of a metre from pair to pair, the last pair being next to the
/// first.
std::vector<ImagePair> RenderDrive(int count, int lamps, unsigned seed);

}  // namespace adit::bench
