// Where light is collected: one float a pixel, and which parts of the image hold any.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace adit::sim {

/// A rectangle of pixels: x from x0 to x1 - 1, y from y0 to y1 - 1.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool Empty() const { return x0 >= x1 || y0 >= y1; }
  PixelBox Cut(const PixelBox& other) const {
    return {std::max(x0, other.x0), std::max(y0, other.y0), std::min(x1, other.x1), std::min(y1, other.y1)};
  }
  static constexpr double kFar = 1e6;  ///< beyond any image, and still an int
  /// The pixels whose centres are within `reach_px` of (x, y) along both axes, or a few more.
  static PixelBox Around(double x, double y, double reach_px) {
    const auto whole = [](double v) { return static_cast<int>(std::clamp(v, -kFar, kFar)); };
    return {whole(std::floor(x - reach_px)), whole(std::floor(y - reach_px)),
            whole(std::ceil(x + reach_px)) + 1, whole(std::ceil(y + reach_px)) + 1};
  }
};

/// Noise-free light in DN above the background over `Box()`, in tiles: those that were never marked hold 0,
/// and need neither noise of their own nor clearing.
class Canvas {
 public:
  static constexpr int kTileWidth = 64, kTileHeight = 16;

  explicit Canvas(const PixelBox& box)
      : box_(box),
        width_(std::max(box.x1 - box.x0, 0)),
        columns_((width_ + kTileWidth - 1) / kTileWidth),
        rows_((std::max(box.y1 - box.y0, 0) + kTileHeight - 1) / kTileHeight),
        light_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(std::max(box.y1 - box.y0, 0))),
        marked_(static_cast<std::size_t>(columns_ * rows_)) {}

  const PixelBox& Box() const { return box_; }
  /// The row y from x = Box().x0 on. Mark what you write.
  float* Row(int y) { return light_.data() + static_cast<std::ptrdiff_t>(y - box_.y0) * width_; }
  const float* Row(int y) const { return light_.data() + static_cast<std::ptrdiff_t>(y - box_.y0) * width_; }
  float& At(int x, int y) { return Row(y)[x - box_.x0]; }
  float At(int x, int y) const { return Row(y)[x - box_.x0]; }

  /// Marks the tiles that `part` (within Box) touches.
  void Mark(const PixelBox& part) {
    if (part.Empty()) return;
    for (int r = (part.y0 - box_.y0) / kTileHeight; r <= (part.y1 - 1 - box_.y0) / kTileHeight; ++r)
      for (int c = (part.x0 - box_.x0) / kTileWidth; c <= (part.x1 - 1 - box_.x0) / kTileWidth; ++c)
        marked_[static_cast<std::size_t>(r * columns_ + c)] = 1;
  }

  /// Adds `factor` times all of `other` where the two overlap.
  void Add(const Canvas& other, float factor) {
    const PixelBox part = box_.Cut(other.box_);
    for (int y = part.y0; y < part.y1; ++y) {
      const float* const from = other.Row(y) + (part.x0 - other.box_.x0);
      float* const to = Row(y) + (part.x0 - box_.x0);
      for (int x = 0; x < part.x1 - part.x0; ++x) to[x] += factor * from[x];
    }
    Mark(part);
  }

  int TileColumns() const { return columns_; }
  int TileRows() const { return rows_; }
  bool Marked(int column, int row) const {
    return marked_[static_cast<std::size_t>(row * columns_ + column)] != 0;
  }
  PixelBox Tile(int column, int row) const {
    const PixelBox tile{box_.x0 + column * kTileWidth, box_.y0 + row * kTileHeight,
                        box_.x0 + (column + 1) * kTileWidth, box_.y0 + (row + 1) * kTileHeight};
    return tile.Cut(box_);
  }

  /// Back to darkness everywhere.
  void Clear() {
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c)
        if (std::exchange(marked_[static_cast<std::size_t>(r * columns_ + c)], std::uint8_t{0}) != 0)
          ClearTile(Tile(c, r));
  }

 private:
  void ClearTile(const PixelBox& tile) {
    for (int y = tile.y0; y < tile.y1; ++y)
      std::fill_n(Row(y) + (tile.x0 - box_.x0), tile.x1 - tile.x0, 0.0F);
  }

  PixelBox box_;
  int width_, columns_, rows_;
  std::vector<float> light_;
  std::vector<std::uint8_t> marked_;
};

}  // namespace adit::sim
