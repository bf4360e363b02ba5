// The same work by OpenCV: spots of an image and their luminance-weighted centroids.
#pragma once

#include <cstdint>
#include <span>

namespace adit::bench {

/// Keeps OpenCV to the calling thread from now on: its threshold spreads over all cores otherwise, and what
/// is compared is one core with one core. To be called before it is measured.
void KeepOpenCvOnOneCore();

/// threshold + findContours + weighted moments of each contour's box; the number of spots.
std::size_t SegmentByContours(std::span<const std::uint8_t> pixels);

/// threshold + connectedComponentsWithStats (32 bit labels, its default) + weighted centroids; the number of
/// spots.
std::size_t SegmentByComponents(std::span<const std::uint8_t> pixels);

}  // namespace adit::bench
