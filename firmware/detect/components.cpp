#include "firmware/detect/components.h"

#include <algorithm>

namespace adit::detect {
namespace {

/// Ends every row's runs: it is right of all of them, so that no search for a neighbour runs past it.
constexpr Run kSentinel{UINT16_MAX, UINT16_MAX, 0, 0, 0};

}  // namespace

Components::Components() : lit_rows_(kMaxRuns), runs_(kMaxRuns), components_(kMaxRuns), parent_(kMaxRuns) {}

bool Components::Segment(const base::ImageView& image, const Window& window, int threshold) {
  component_count_ = 0;
  if (!lit_rows_.Read(image, window, threshold) || !LinkRows(window.x_min_px)) {
    component_count_ = 0;
    return false;
  }
  DropJoined();
  return true;
}

bool Components::LinkRows(int left_px) {
  x_px_ = static_cast<std::uint16_t>(left_px);
  runs_[0] = kSentinel;  // what is above a row that follows a dark one; and no run has the number 0
  run_count_ = 1;
  std::uint32_t above = 0;  // first run of the row y_px_
  for (std::size_t band = 0; band < kBands; ++band) {
    for (const LitRow& row : lit_rows_.Band(band)) {
      if (run_count_ + row.edge_count / 2 + 1 > kMaxRuns) return false;
      if (row.y_px != y_px_ + 1) above = 0;
      const std::uint32_t here = run_count_;
      y_px_ = row.y_px;
      Link(above, lit_rows_.EdgesOf(row));
      runs_[run_count_++] = kSentinel;
      above = here;
    }
  }
  return true;
}

void Components::Link(std::uint32_t above, std::span<const std::uint16_t> edges) {
  Run* const runs = runs_.data();
  const Run* up = runs + above;
  std::uint32_t run = run_count_;
  for (std::size_t i = 0; i < edges.size(); i += 2, ++run) {
    const std::uint32_t begin_px = x_px_ + edges[i], end_px = x_px_ + edges[i + 1];
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
