// A part of an image that is searched instead of the whole.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/base/fixed_vector.h"

namespace adit::detect {

/// Pixels [x_min, x_max] x [y_min, y_max], inside the image. What touches its edge may be cut and is not
/// measured.
struct Window {
  int x_min_px = 0, y_min_px = 0, x_max_px = 0, y_max_px = 0;

  int WidthPx() const { return x_max_px - x_min_px + 1; }
  int HeightPx() const { return y_max_px - y_min_px + 1; }
};

inline constexpr std::size_t kMaxWindows = 32;

/// Windows that do not overlap; none: the whole image.
using Windows = base::FixedVector<Window, kMaxWindows>;

/// Adds `window`, joined with all that it overlaps. Declines when there is no room.
bool Add(Windows& windows, Window window);

}  // namespace adit::detect
