// The dark level of an image and its noise, from a sparse sample.
#pragma once

#include "firmware/base/image.h"

namespace adit::detect {

/// Level and noise of the unlit part, in DN of the image's own bits.
struct Background {
  double level_dn = 0;
  double noise_dn = 0;  ///< one standard deviation
};

/// The median of an eighth of eight rows, in pieces of 32 pixels, and the distance from there to the 16 %
/// quantile: lights, up to a third of the image, brighten neither much. No state, no heap: a replay sees the
/// same. `image` must not be empty.
Background EstimateBackground(const base::ImageView& image);

/// Tells the memory that EstimateBackground will be asked.
void FetchBackground(const base::ImageView& image);

}  // namespace adit::detect
