// What the identification hands on: which four blobs are the LEDs of which target.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/target.h"
#include "firmware/detect/blob_set.h"

namespace adit::identify {

inline constexpr std::size_t kMaxTargets = 32;  ///< models a box can hold
inline constexpr std::size_t kMaxSightings =
    256;  ///< candidates per image: a row of twenty lamps in line with a bar makes 100

/// Four blobs that pass for a target in one image.
struct Sighting {
  std::uint8_t target = 0;                             ///< index into the model list
  std::array<std::uint16_t, base::kLedCount> blobs{};  ///< indices into the BlobSet, LED 1 to LED 4
  float p2 = 0;                                        ///< the measured invariant (seed 2.2.2.1)
  float collinearity_px = 0;                           ///< rms distance of the four from their line
  float length_px = 0;                                 ///< LED 1 to LED 4
};

/// All sightings of one image. More than one per target may stand here: the geometry of the pair decides
/// between them.
struct SightingSet {
  const detect::BlobSet* blob_set = nullptr;  ///< the predecessor; outlives this record
  base::FixedVector<Sighting, kMaxSightings> sightings;
  std::uint32_t no_room = 0;  ///< sightings that did not fit
  bool cut_short = false;     ///< the search reached its budget: sightings may be missing
};

}  // namespace adit::identify
