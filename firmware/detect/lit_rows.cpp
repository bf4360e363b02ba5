#include "firmware/detect/lit_rows.h"

#include "firmware/base/require.h"

namespace adit::detect {

LitRows::LitRows(std::size_t max_runs)
    : scans_{FastestRowScan(1), FastestRowScan(2)},
      dark_scans_{FastestDarkScan(1), FastestDarkScan(2)},
      max_edges_(2 * max_runs),
      words_(LitWordsRoom(kMaxSidePx)),
      edges_(max_edges_ + RowEdgesRoom(kMaxSidePx)),
      rows_(kMaxSidePx + kBands) {}

bool LitRows::Read(const base::ImageView& image, const Window& window, int threshold) {
  ADIT_REQUIRE(image.width_px <= kMaxSidePx && image.height_px <= kMaxSidePx);
  const auto bytes_per_pixel = static_cast<std::size_t>(image.BytesPerPixel());
  const RowScan scan = scans_[bytes_per_pixel - 1];
  const DarkScan dark_scan = dark_scans_[bytes_per_pixel - 1];
  const auto height = static_cast<std::size_t>(window.HeightPx());
  rows_a_band_ = (height + kBands - 1) / kBands;
  row_counts_ = {};
  edge_count_ = 0;
  const auto y_of = [&](std::size_t i) { return window.y_min_px + static_cast<int>(i); };
  const auto at = [&](std::size_t i) {
    return image.Row(y_of(i)) + std::ptrdiff_t{window.x_min_px} * image.BytesPerPixel();
  };
  const std::size_t row_bytes = static_cast<std::size_t>(window.WidthPx()) * bytes_per_pixel;
  const bool gapless = image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes);
  const std::size_t before_last = (kBands - 1) * rows_a_band_;  // the last band has the fewest rows
  const std::size_t rows_of_each = gapless && height > before_last ? height - before_last : 0;
  bool dark = true;  // the row before in every band: the next one is mostly like it
  for (std::size_t row = 0; row < rows_a_band_; ++row) {
    if (dark && row < rows_of_each) {
      Bands bands;
      for (std::size_t band = 0; band < kBands; ++band) bands[band] = at(band * rows_a_band_ + row);
      const std::size_t rest_bytes = (rows_of_each - row) * row_bytes;
      row += dark_scan(bands, rest_bytes, threshold) / row_bytes;
      if (row == rows_a_band_) break;
    }
    dark = true;
    for (std::size_t band = 0, i = row; band < kBands && i < height; ++band, i += rows_a_band_) {
      const std::size_t lit = scan(at(i), window.WidthPx(), threshold, words_.data());
      if (lit == 0) continue;
      dark = false;
      if (!Keep({words_.data(), lit}, band, y_of(i))) return false;
    }
  }
  return true;
}

bool LitRows::Keep(std::span<const LitWord> words, std::size_t band, int y_px) {
  const std::size_t edges = RowEdges(words, edges_.data() + edge_count_);
  rows_[band * rows_a_band_ + row_counts_[band]++] = {static_cast<std::uint32_t>(edge_count_),
                                                      static_cast<std::uint16_t>(edges),
                                                      static_cast<std::uint16_t>(y_px)};
  edge_count_ += edges;
  return edge_count_ <= max_edges_;
}

}  // namespace adit::detect
