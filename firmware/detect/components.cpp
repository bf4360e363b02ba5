#include "firmware/detect/components.h"

#include <algorithm>

#include "firmware/base/require.h"

namespace adit::detect {
namespace {

// Words of 64 pixels that are lit in a row up to which looking for dark blocks pays: where two LEDs or one
// lamp are. Measured.
constexpr std::size_t kFewWords = 2;

/// Ends every row's runs: it is right of all of them, so that no search for a neighbour runs past it.
constexpr Run kSentinel{UINT16_MAX, UINT16_MAX, 0, 0, 0};

}  // namespace

Components::Components()
    : scans_{{{FastestRowScan(1, true), FastestRowScan(1, false)},
              {FastestRowScan(2, true), FastestRowScan(2, false)}}},
      dark_scans_{FastestDarkScan(1), FastestDarkScan(2)},
      lit_(LitWordsRoom(kMaxWidthPx)),
      edges_(RowEdgesRoom(kMaxWidthPx)),
      runs_(kMaxRuns),
      components_(kMaxRuns),
      parent_(kMaxRuns) {}

bool Components::Segment(const base::ImageView& image, const Window& window, int threshold) {
  ADIT_REQUIRE(image.width_px <= kMaxWidthPx && image.height_px <= UINT16_MAX);
  component_count_ = 0;
  if (!ReadRows(image, window, threshold)) {
    component_count_ = 0;
    return false;
  }
  DropJoined();
  return true;
}

bool Components::ReadRows(const base::ImageView& image, const Window& window, int threshold) {
  const auto bytes_per_pixel = static_cast<std::size_t>(image.BytesPerPixel());
  const auto& scans = scans_[bytes_per_pixel - 1];
  const std::ptrdiff_t left_bytes = std::ptrdiff_t{window.x_min_px} * image.BytesPerPixel();
  x_px_ = static_cast<std::uint16_t>(window.x_min_px);
  runs_[0] = kSentinel;  // what is above a row that follows a dark one; and no run has the number 0
  run_count_ = 1;
  std::uint32_t above = 0;
  std::size_t lit = 0;
  const auto row_bytes = static_cast<std::size_t>(window.WidthPx()) * bytes_per_pixel;
  const bool gapless = image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes);
  for (int y = window.y_min_px; y <= window.y_max_px; ++y) {
    // A row is like the one above it.
    if (gapless && lit == 0) {
      const auto rows = static_cast<std::size_t>(window.y_max_px - y + 1);
      y += static_cast<int>(dark_scans_[bytes_per_pixel - 1](image.Row(y), rows * row_bytes, threshold) /
                            row_bytes);
      if (y > window.y_max_px) break;
    }
    lit = scans[lit > kFewWords ? 1 : 0](image.Row(y) + left_bytes, window.WidthPx(), threshold, lit_.data());
    if (lit == 0) {
      above = 0;
      continue;
    }
    const std::size_t edges = RowEdges({lit_.data(), lit}, edges_.data());
    if (run_count_ + edges / 2 + 1 > kMaxRuns) return false;
    const std::uint32_t here = run_count_;
    y_px_ = static_cast<std::uint16_t>(y);
    Link(above, edges);
    runs_[run_count_++] = kSentinel;
    above = here;
  }
  return true;
}

void Components::Link(std::uint32_t above, std::size_t edges) {
  Run* const runs = runs_.data();
  const Run* up = runs + above;
  std::uint32_t run = run_count_;
  for (std::size_t i = 0; i < edges; i += 2, ++run) {
    const std::uint32_t begin_px = x_px_ + edges_[i], end_px = x_px_ + edges_[i + 1];
    // Diagonal neighbours count: ends are exclusive, so equality touches.
    while (up->end_px < begin_px) ++up;
    const bool joins = up->begin_px <= end_px;
    std::uint32_t component = joins ? Root(up->component) : component_count_;
    // The last of those that touch may touch the next run too: it stays.
    while (joins && up[1].begin_px <= end_px) component = Join(component, Root((++up)->component));
    runs[run] = {static_cast<std::uint16_t>(begin_px), static_cast<std::uint16_t>(end_px), y_px_, component,
                 0};
    if (joins)
      Append(component, run);
    else
      Open(run);
  }
  run_count_ = run;
}

void Components::Open(std::uint32_t run) {
  const Run& r = runs_[run];
  const auto last_x_px = static_cast<std::uint16_t>(r.end_px - 1);
  const auto length_px = static_cast<std::uint32_t>(r.end_px - r.begin_px);
  components_[component_count_] = {length_px, r.begin_px, r.y_px, last_x_px, r.y_px, run, run};
  parent_[component_count_] = component_count_;
  ++component_count_;
}

void Components::Append(std::uint32_t component, std::uint32_t run) {
  const Run& r = runs_[run];
  Component& c = components_[component];
  runs_[c.last_run].next = run;
  c.last_run = run;
  c.area_px += static_cast<std::uint32_t>(r.end_px - r.begin_px);
  c.x_min_px = std::min(c.x_min_px, r.begin_px);
  c.x_max_px = std::max(c.x_max_px, static_cast<std::uint16_t>(r.end_px - 1));
  c.y_max_px = r.y_px;
}

std::uint32_t Components::Join(std::uint32_t a, std::uint32_t b) {
  if (a == b) return a;
  const std::uint32_t root = std::min(a, b), gone = std::max(a, b);
  parent_[gone] = root;
  Component &kept = components_[root], &joined = components_[gone];
  kept.area_px += joined.area_px;
  kept.x_min_px = std::min(kept.x_min_px, joined.x_min_px);
  kept.x_max_px = std::max(kept.x_max_px, joined.x_max_px);
  kept.y_max_px = std::max(kept.y_max_px, joined.y_max_px);
  runs_[kept.last_run].next = joined.first_run;
  kept.last_run = joined.last_run;
  joined.area_px = 0;
  return root;
}

std::uint32_t Components::Root(std::uint32_t component) {
  while (parent_[component] != component) {
    parent_[component] = parent_[parent_[component]];  // halves the path for the next time
    component = parent_[component];
  }
  return component;
}

void Components::DropJoined() {
  const auto first = components_.begin(), end = first + component_count_;
  const auto kept = std::remove_if(first, end, [](const Component& c) { return c.area_px == 0; });
  component_count_ = static_cast<std::uint32_t>(kept - first);
}

}  // namespace adit::detect
