#include "firmware/detect/components.h"

#include <algorithm>

namespace adit::detect {

Components::Components()
    : scan8_(FastestRowScan()),
      runs_(kMaxRuns),
      parent_(kMaxRuns),
      component_of_(kMaxRuns),
      components_(kMaxRuns) {}

bool Components::Segment(const base::ImageView& image, int threshold) {
  run_count_ = component_count_ = 0;
  if (!ScanRows(image, threshold)) {
    run_count_ = 0;
    return false;
  }
  Collect();
  return true;
}

bool Components::ScanRows(const base::ImageView& image, int threshold) {
  const RowScan scan = image.BytesPerPixel() == 1 ? scan8_ : ScanRowPlain16;
  RowSpan above;
  for (int y = 0; y < image.height_px; ++y) {
    const std::size_t room = kMaxRuns - run_count_;
    const std::size_t found = scan(image.Row(y), image.width_px, threshold, &runs_[run_count_], room);
    if (found > room || run_count_ + found == kMaxRuns) return false;
    const RowSpan here{run_count_, run_count_ + found};
    for (std::size_t i = here.begin; i < here.end; ++i) {
      runs_[i].y_px = static_cast<std::uint16_t>(y);
      parent_[i] = static_cast<std::uint32_t>(i);
    }
    run_count_ = here.end;
    if (above.begin != above.end && here.begin != here.end) Link(above, here);
    above = here;
  }
  return true;
}

void Components::Link(RowSpan above, RowSpan here) {
  std::size_t a = above.begin, h = here.begin;
  while (a < above.end && h < here.end) {
    // Diagonal neighbours count: ends are exclusive, so equality touches.
    if (runs_[a].begin_px <= runs_[h].end_px && runs_[h].begin_px <= runs_[a].end_px) {
      const std::uint32_t first = Root(static_cast<std::uint32_t>(a)),
                          second = Root(static_cast<std::uint32_t>(h));
      parent_[std::max(first, second)] = std::min(first, second);
    }
    // The one that ends first can touch nothing further.
    if (runs_[a].end_px < runs_[h].end_px) {
      ++a;
    } else {
      ++h;
    }
  }
}

std::uint32_t Components::Root(std::uint32_t run) {
  while (parent_[run] != run) {
    parent_[run] = parent_[parent_[run]];  // halves the path for the next time
    run = parent_[run];
  }
  return run;
}

void Components::Collect() {
  for (std::size_t i = 0; i < run_count_; ++i) {
    const Run& run = runs_[i];
    const std::uint32_t root = Root(static_cast<std::uint32_t>(i));
    const auto last_x_px = static_cast<std::uint16_t>(run.end_px - 1);
    const std::uint32_t length = static_cast<std::uint32_t>(run.end_px) - run.begin_px;
    if (root == i) {  // roots come before the rest of their component
      component_of_[i] = static_cast<std::uint32_t>(component_count_);
      components_[component_count_++] = {length, run.begin_px, run.y_px, last_x_px, run.y_px};
      continue;
    }
    component_of_[i] = component_of_[root];
    Component& component = components_[component_of_[i]];
    component.area_px += length;
    component.x_min_px = std::min(component.x_min_px, run.begin_px);
    component.x_max_px = std::max(component.x_max_px, last_x_px);
    component.y_max_px = run.y_px;
  }
}

}  // namespace adit::detect
