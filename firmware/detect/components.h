// Runs -> connected components (8 neighbours), by union-find while the rows come.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/detect/row_scan.h"

namespace adit::detect {

/// What is known of a component without looking at its pixels again.
struct Component {
  std::uint32_t area_px = 0;
  std::uint16_t x_min_px = 0, y_min_px = 0, x_max_px = 0, y_max_px = 0;  ///< bounding box, inclusive
};

/// The segmentation of one image. All storage is made by the constructor.
class Components {
 public:
  /// More runs than this in one image are not kept: such an image has no dark background.
  static constexpr std::size_t kMaxRuns = 1 << 17;

  Components();

  /// Finds all components of pixels brighter than `threshold` (in the image's own DN). False if there were
  /// too many runs: then there are no components at all, rather than wrong ones.
  bool Segment(const base::ImageView& image, int threshold);

  /// All components, in the order of their first runs.
  std::span<const Component> All() const { return {components_.data(), component_count_}; }
  /// All runs, in scan order, and the component (index into All) of each.
  std::span<const Run> Runs() const { return {runs_.data(), run_count_}; }
  std::uint32_t ComponentOf(std::size_t run) const { return component_of_[run]; }

 private:
  struct RowSpan {
    std::size_t begin = 0, end = 0;  ///< indices into runs_
  };
  bool ScanRows(const base::ImageView& image, int threshold);
  void Link(RowSpan above, RowSpan here);
  std::uint32_t Root(std::uint32_t run);
  void Collect();

  RowScan scan8_;
  std::vector<Run> runs_;
  std::vector<std::uint32_t> parent_;        ///< of each run; the earliest run of a component is its root
  std::vector<std::uint32_t> component_of_;  ///< of each run
  std::vector<Component> components_;
  std::size_t run_count_ = 0, component_count_ = 0;
};

}  // namespace adit::detect
