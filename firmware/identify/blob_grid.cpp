#include "firmware/identify/blob_grid.h"

#include <cmath>
#include <limits>

namespace adit::identify {
namespace {

double LargerEigenvalue(const Eigen::Matrix2d& m) {
  const double half_sum = 0.5 * (m(0, 0) + m(1, 1)), half_difference = 0.5 * (m(0, 0) - m(1, 1));
  return half_sum + std::sqrt(half_difference * half_difference + m(0, 1) * m(0, 1));
}

bool Usable(const detect::Blob& blob) {
  // Written so that NaN fails.
  const double variance = LargerEigenvalue(blob.covariance_px2);
  return std::isfinite(blob.ideal_px.x()) && std::isfinite(blob.ideal_px.y()) && variance >= 0 &&
         variance <= BlobGrid::kNoiseMaxPx * BlobGrid::kNoiseMaxPx;
}

}  // namespace

void BlobGrid::Build(const detect::BlobSet& blobs) {
  std::array<std::uint16_t, detect::kMaxBlobs> used;
  size_ = 0;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max()), high = -low;
  for (std::size_t i = 0; i < blobs.blobs.size(); ++i) {
    if (!Usable(blobs.blobs[i])) continue;
    used[size_++] = static_cast<std::uint16_t>(i);
    low = low.cwiseMin(blobs.blobs[i].ideal_px);
    high = high.cwiseMax(blobs.blobs[i].ideal_px);
  }
  variance_max_px2_ = 0;
  if (size_ == 0) return;
  // Some sixteen cells a blob: with fewer a box holds more blobs, with more it takes longer to lay them out.
  constexpr double kCellsPerRoot = 4;
  cells_ =
      std::min(kCells, 1 + static_cast<std::size_t>(kCellsPerRoot * std::sqrt(static_cast<double>(size_))));
  const std::size_t count = cells_ * cells_;
  std::fill_n(start_.begin(), count + 1, std::uint16_t{0});
  origin_px_ = low, extent_px_ = high - low;
  constexpr double kSmallestCellPx = 16;  // smaller ones only make boxes of more cells
  cells_per_px_ = 1 / std::max(kSmallestCellPx, (high - low).maxCoeff() / static_cast<double>(cells_));

  // Counting sort. Afterwards start_[c] is the first blob of cell c, start_[c + 1] the end.
  std::array<std::uint16_t, detect::kMaxBlobs> cell;
  for (std::size_t i = 0; i < size_; ++i) {
    cell[i] = static_cast<std::uint16_t>(Cell(blobs.blobs[used[i]].ideal_px));
    ++start_[cell[i] + 1U];
  }
  for (std::size_t c = 1; c <= count; ++c) start_[c] = static_cast<std::uint16_t>(start_[c] + start_[c - 1]);
  for (std::size_t i = size_; i-- > 0;) {
    const detect::Blob& blob = blobs.blobs[used[i]];
    // Filling each cell from its end moves start_[c + 1] down to the cell's first; shifted back below.
    const std::size_t slot = --start_[cell[i] + 1U];
    x_px_[slot] = blob.ideal_px.x(), y_px_[slot] = blob.ideal_px.y();
    variance_px2_[slot] = LargerEigenvalue(blob.covariance_px2);
    variance_max_px2_ = std::max(variance_max_px2_, variance_px2_[slot]);
    index_[slot] = used[i];
  }
  for (std::size_t c = 0; c < count; ++c) start_[c] = start_[c + 1];
  start_[count] = static_cast<std::uint16_t>(size_);
}

}  // namespace adit::identify
