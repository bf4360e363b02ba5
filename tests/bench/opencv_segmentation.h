// The same work by OpenCV: spots of an image and their luminance-weighted centroids.
#pragma once

#include <cstdint>
#include <span>

namespace adit::bench {

/// threshold + findContours + weighted moments of each contour's box; the number of spots.
std::size_t SegmentByContours(std::span<const std::uint8_t> pixels);

/// threshold + connectedComponentsWithStats (32 bit labels, its default) + weighted centroids; the number of
/// spots.
std::size_t SegmentByComponents(std::span<const std::uint8_t> pixels);

}  // namespace adit::bench
