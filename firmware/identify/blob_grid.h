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
    for (int y = y0; y <= y1; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * kCells;
      const std::size_t end = start_[row + static_cast<std::size_t>(x1) + 1];
      for (std::size_t i = start_[row + static_cast<std::size_t>(x0)]; i < end; ++i) visit(i);
    }
  }

 private:
  static constexpr std::size_t kCells = 64;  // a side: about 22 px for a 1400 px image

  int Column(double offset_px) const {
    return static_cast<int>(std::clamp(offset_px * cells_per_px_, 0.0, static_cast<double>(kCells - 1)));
  }
  std::size_t Cell(const Eigen::Vector2d& place_px) const {
    return static_cast<std::size_t>(Column(place_px.y() - origin_px_.y())) * kCells +
           static_cast<std::size_t>(Column(place_px.x() - origin_px_.x()));
  }

  Eigen::Vector2d origin_px_ = Eigen::Vector2d::Zero();
  double cells_per_px_ = 1;
  double variance_max_px2_ = 0;
  std::size_t size_ = 0;
  std::array<double, detect::kMaxBlobs> x_px_{}, y_px_{}, variance_px2_{};
  std::array<std::uint16_t, detect::kMaxBlobs> index_{};
  std::array<std::uint16_t, kCells * kCells + 1> start_{};
};

}  // namespace adit::identify
