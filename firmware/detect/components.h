// Bright runs -> connected components (8 neighbours), by union-find while the rows come.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/detect/lit_rows.h"
#include "firmware/detect/window.h"

namespace adit::detect {

/// Bright pixels [begin_px, end_px) of row y_px with dark ones, or the border, on either side.
struct Run {
  std::uint16_t begin_px = 0, end_px = 0, y_px = 0;
  std::uint32_t component =
      0;                   ///< the one it was given to when its row was read; others may have joined since
  std::uint32_t next = 0;  ///< another run of the same component, or 0
};

/// The runs of one component, in no particular order: a list through `next`.
class RunList {
 public:
  class Iterator {
   public:
    Iterator(const Run* all, std::uint32_t at) : all_(all), at_(at) {}
    const Run& operator*() const { return all_[at_]; }
    Iterator& operator++() {
      at_ = all_[at_].next;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return at_ != other.at_; }

   private:
    const Run* all_;
    std::uint32_t at_;
  };

  /// From the run `first` of `all` on, to the one whose next is 0.
  RunList(const Run* all, std::uint32_t first) : all_(all), first_(first) {}
  Iterator begin() const { return {all_, first_}; }
  Iterator end() const { return {all_, 0}; }

 private:
  const Run* all_;
  std::uint32_t first_;
};

/// What is known of a component without looking at its pixels again.
struct Component {
  std::uint32_t area_px = 0;
  std::uint16_t x_min_px = 0, y_min_px = 0, x_max_px = 0, y_max_px = 0;  ///< bounding box, inclusive
  std::uint32_t first_run = 0, last_run = 0;                             ///< ends of its list of runs
};

/// The segmentation of one image. All storage is made by the constructor.
class Components {
 public:
  /// More runs than this in one image are not kept: such an image has no dark background.
  static constexpr std::size_t kMaxRuns = 1 << 17;

  Components();

  /// Finds all components of pixels brighter than `threshold` (in the image's own DN) inside `window`. False
  /// if there were too many runs: then there are no components at all, rather than wrong ones.
  bool Segment(const base::ImageView& image, const Window& window, int threshold);

  /// All components, in the order of their first pixels in the image.
  std::span<const Component> All() const { return {components_.data(), component_count_}; }

  RunList RunsOf(const Component& component) const { return {runs_.data(), component.first_run}; }

 private:
  bool LinkRows(int left_px);
  void Link(std::uint32_t above, std::span<const std::uint16_t> edges);
  void Open(std::uint32_t run);
  void Append(std::uint32_t component, std::uint32_t run);
  std::uint32_t Join(std::uint32_t a, std::uint32_t b);
  std::uint32_t Root(std::uint32_t component);
  void DropJoined();

  LitRows lit_rows_;
  std::uint16_t x_px_ = 0, y_px_ = 0;  ///< of the window's left edge and of the row at hand
  std::vector<Run> runs_;              ///< row by row, a sentinel after each
  std::vector<Component> components_;
  std::vector<std::uint32_t> parent_;  ///< of each component; the earliest of those that meet is their root
  std::uint32_t run_count_ = 0, component_count_ = 0;
};

}  // namespace adit::detect
