#include "firmware/detect/window.h"

#include <algorithm>

namespace adit::detect {
namespace {

bool Overlap(const Window& a, const Window& b) {
  return a.x_min_px <= b.x_max_px && b.x_min_px <= a.x_max_px && a.y_min_px <= b.y_max_px &&
         b.y_min_px <= a.y_max_px;
}

}  // namespace

bool Add(Windows& windows, Window window) {
  // A joined window is larger and may overlap more: until nothing changes.
  for (std::size_t i = 0; i < windows.size();) {
    const Window other = windows[i];
    if (!Overlap(window, other)) {
      ++i;
      continue;
    }
    window = {std::min(window.x_min_px, other.x_min_px), std::min(window.y_min_px, other.y_min_px),
              std::max(window.x_max_px, other.x_max_px), std::max(window.y_max_px, other.y_max_px)};
    windows[i] = windows.back();
    windows.Truncate(windows.size() - 1);
    i = 0;
  }
  return windows.push_back(window);
}

}  // namespace adit::detect
