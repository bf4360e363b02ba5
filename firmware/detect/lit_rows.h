// An image -> the bright runs of each of its rows, read as fast as the memory gives it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/detect/row_scan.h"
#include "firmware/detect/window.h"

namespace adit::detect {

/// A row that holds something bright.
struct LitRow {
  std::uint32_t first_edge = 0;  ///< see EdgesOf
  std::uint16_t edge_count = 0;
  std::uint16_t y_px = 0;
};

/// The lit rows of one image. It is read in bands, a row of each in turn: to the processor these are as many
/// streams, and it fetches ahead in each: what is read one after the other waits at every page of memory. All
/// storage is made by the constructor.
class LitRows {
 public:
  static constexpr int kMaxSidePx = 1 << 14;  ///< far more than any camera of this use has

  /// Makes room for `max_runs` bright runs.
  explicit LitRows(std::size_t max_runs);

  /// Finds what is brighter than `threshold` (in the image's own DN) inside `window`. False, and all that
  /// came so far, if there was no room for more.
  bool Read(const base::ImageView& image, const Window& window, int threshold);

  /// The lit rows of a band in ascending order; those of the next are all below them.
  std::span<const LitRow> Band(std::size_t i) const {
    return {rows_.data() + i * rows_a_band_, row_counts_[i]};
  }
  /// As RowEdges tells them, counted from the window's left edge.
  std::span<const std::uint16_t> EdgesOf(const LitRow& row) const {
    return {edges_.data() + row.first_edge, row.edge_count};
  }

 private:
  bool Keep(std::span<const LitWord> words, std::size_t band, int y_px);

  std::array<RowScan, 2> scans_;        ///< by bytes of a pixel less one
  std::array<DarkScan, 2> dark_scans_;  ///< the same
  std::size_t max_edges_;
  std::vector<LitWord> words_;  ///< of the row at hand
  std::vector<std::uint16_t> edges_;
  std::size_t edge_count_ = 0;
  std::vector<LitRow> rows_;     ///< those of band i from i * rows_a_band_ on
  std::size_t rows_a_band_ = 0;  ///< of the image, lit or not; the last band may have fewer
  std::array<std::size_t, kBands> row_counts_{};
};

}  // namespace adit::detect
