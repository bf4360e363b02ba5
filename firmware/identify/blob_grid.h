// The blobs of one image sorted into square cells, so that a search looks only where something can be.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/detect/blob_set.h"

namespace adit::identify {

/// Places and noise of the blobs as separate arrays, sorted by cell, row by row: the cells of one row that a
/// box covers are one contiguous run. Blobs that are not finite or whose noise exceeds kNoiseMaxPx are left
/// out. No heap.
class BlobGrid {
 public:
  static constexpr double kNoiseMaxPx = 1.0;  ///< an LED image worth measuring is ten times better

  void Build(const detect::BlobSet& blobs);

  std::size_t size() const { return size_; }
  /// Whether a place lies among the blobs, give or take `margin_px`.
  bool Encloses(const Eigen::Vector2d& place_px, double margin_px) const {
    const Eigen::Vector2d offset = place_px - origin_px_;
    return offset.x() >= -margin_px && offset.y() >= -margin_px && offset.x() <= extent_px_.x() + margin_px &&
           offset.y() <= extent_px_.y() + margin_px;
  }
  Eigen::Vector2d Place(std::size_t i) const { return {x_px_[i], y_px_[i]}; }
  double X(std::size_t i) const { return x_px_[i]; }
  double Y(std::size_t i) const { return y_px_[i]; }
  /// Larger eigenvalue of the blob's covariance, px^2.
  double Variance(std::size_t i) const { return variance_px2_[i]; }
  double VarianceMax() const { return variance_max_px2_; }
  /// Index of the blob in its BlobSet.
  std::uint16_t Index(std::size_t i) const { return index_[i]; }

  /// Calls visit(i) for every blob of the cells that the box touches (the caller tests the place itself).
  template <class Visit>
  void VisitBox(const Eigen::Vector2d& low_px, const Eigen::Vector2d& high_px, Visit visit) const {
    if (size_ == 0) return;
    const int x0 = Column(low_px.x() - origin_px_.x()), x1 = Column(high_px.x() - origin_px_.x());
    const int y0 = Column(low_px.y() - origin_px_.y()), y1 = Column(high_px.y() - origin_px_.y());
    for (int y = y0; y <= y1; ++y) VisitRow(y, x0, x1, visit);
  }

  /// The same for the cells within `reach_px` of the segment from `p_px` to `q_px`.
  template <class Visit>
  void VisitStrip(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, double reach_px,
                  Visit visit) const {
    if (size_ == 0) return;
    const Eigen::Vector2d p = p_px - origin_px_, step = q_px - p_px;
    const double low_y = std::min(p.y(), p.y() + step.y()) - reach_px;
    const double high_y = std::max(p.y(), p.y() + step.y()) + reach_px;
    // The image ends where its blobs do.
    if (high_y < 0 || low_y * cells_per_px_ >= static_cast<double>(cells_)) return;
    const int y0 = Column(low_y), y1 = Column(high_y);
    const double cell_px = 1 / cells_per_px_, per_step = 1 / step.y();
    for (int y = y0; y <= y1; ++y) {
      // The part of the segment, 0 to 1, whose reach touches this row of cells.
      double from = 0, to = 1;
      if (y0 != y1 && step.y() != 0) {
        const double a = (y * cell_px - reach_px - p.y()) * per_step;
        const double b = ((y + 1) * cell_px + reach_px - p.y()) * per_step;
        from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
        if (from > to) continue;
      }
      const double xa = p.x() + from * step.x(), xb = p.x() + to * step.x();
      const double low_x = std::min(xa, xb) - reach_px, high_x = std::max(xa, xb) + reach_px;
      if (high_x < 0 || low_x * cells_per_px_ >= static_cast<double>(cells_)) continue;
      VisitRow(y, Column(low_x), Column(high_x), visit);
    }
  }

 private:
  static constexpr std::size_t kCells = 64;  // a side at most: about 22 px for a 1400 px image

  template <class Visit>
  void VisitRow(int y, int x0, int x1, Visit& visit) const {
    const std::size_t row = static_cast<std::size_t>(y) * cells_;
    const std::size_t end = start_[row + static_cast<std::size_t>(x1) + 1];
    for (std::size_t i = start_[row + static_cast<std::size_t>(x0)]; i < end; ++i) visit(i);
  }

  int Column(double offset_px) const {
    return static_cast<int>(std::clamp(offset_px * cells_per_px_, 0.0, static_cast<double>(cells_ - 1)));
  }
  std::size_t Cell(const Eigen::Vector2d& place_px) const {
    return static_cast<std::size_t>(Column(place_px.y() - origin_px_.y())) * cells_ +
           static_cast<std::size_t>(Column(place_px.x() - origin_px_.x()));
  }

  Eigen::Vector2d origin_px_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d extent_px_ = Eigen::Vector2d::Zero();
  double cells_per_px_ = 1;
  double variance_max_px2_ = 0;
  std::size_t size_ = 0, cells_ = 1;  ///< blobs; cells a side
  std::array<double, detect::kMaxBlobs> x_px_{}, y_px_{}, variance_px2_{};
  std::array<std::uint16_t, detect::kMaxBlobs> index_{};
  std::array<std::uint16_t, kCells * kCells + 1> start_{};
};

}  // namespace adit::identify
