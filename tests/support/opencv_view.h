// OpenCV's images as the rooms see them.
#pragma once

#include <opencv2/core.hpp>

#include "firmware/base/image.h"
#include "firmware/detect/window.h"

namespace adit::support {

/// 8 bit, or 12 in 16. The pixels stay with `image`.
inline base::ImageView ViewOf(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step),
          image.elemSize() == 1 ? 8 : 12};
}

inline detect::Window WholeOf(const base::ImageView& image) {
  return {0, 0, image.width_px - 1, image.height_px - 1};
}

}  // namespace adit::support
