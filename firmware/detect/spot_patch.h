// The pixels around one spot, as the fits want them: floats, in rows of whole vectors.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "firmware/base/image.h"

namespace adit::detect {

/// A rectangle of pixels, of odd width and height, whose middle is the pixel nearest to a spot.
struct SpotPatch {
  static constexpr int kReachMaxPx = 15;  ///< from the middle to the edge
  static constexpr int kLanes = 8;        ///< floats of one vector
  static constexpr int kRowFloats = 32;   ///< four vectors
  static constexpr std::size_t kFloats = kRowFloats * (2 * kReachMaxPx + 1);

  int x_px = 0, y_px = 0;              ///< the middle
  int reach_x_px = 0, reach_y_px = 0;  ///< from there to the edges
  int vectors = 0;                     ///< of a row; what is beyond the edge is any finite number
  float background_dn = 0;             ///< mean of the outermost pixels
  int bright_px = 0;                   ///< pixels above the threshold
  alignas(32) std::array<float, kFloats> value_dn;  ///< row by row, background included

  int WidthPx() const { return 2 * reach_x_px + 1; }
  int HeightPx() const { return 2 * reach_y_px + 1; }
  const float* Row(int row) const { return value_dn.data() + static_cast<std::size_t>(kRowFloats * row); }
};

/// Fills `patch` with what lies up to `reach_px` (at most kReachMaxPx) around `middle_px`. At the image's
/// border it gets narrower on both sides, so that nothing leans to one. False if nothing is left around the
/// middle.
bool Load(const base::ImageView& image, const Eigen::Vector2d& middle_px, const Eigen::Vector2d& reach_px,
          int threshold_dn, SpotPatch& patch);

}  // namespace adit::detect
