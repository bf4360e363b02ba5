// Where in the image corners were measured: distortion is known there, and extrapolated elsewhere.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

namespace adit::host {

/// Counts of corners in 8 x 6 cells of the image.
class CoverageMap {
 public:
  static constexpr int kColumns = 8, kRows = 6;

  CoverageMap(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {}

  /// Counts raw pixels; those outside the image count in the nearest cell.
  void Add(std::span<const Eigen::Vector2d> corners_px);
  int Count(int column, int row) const { return counts_[static_cast<std::size_t>(row * kColumns + column)]; }
  /// Share of the cells that hold a corner.
  double Pct() const;
  /// Distance of the farthest corner from the image's middle, as a share of the image corner's.
  double Reach() const { return reach_; }
  /// "upper left", "lower right", ...: the image's corner cells without a corner.
  std::vector<std::string> MissedCorners() const;
  /// The counts as rows of text, a dot for none.
  std::string Text() const;

 private:
  int width_px_, height_px_;
  double reach_ = 0;
  std::array<int, kColumns * kRows> counts_{};
};

/// A corner and how far the solution misses it.
struct CoverageMark {
  Eigen::Vector2d image_px;
  Eigen::Vector2d residual_px;
};

/// The map as a PNG of the image's size: every corner with its residual (50-fold as a line; green within one,
/// yellow within two, red beyond two `sigma0_px`), and cells without corners in red.
std::vector<unsigned char> DrawCoverage(const CoverageMap& map, std::span<const CoverageMark> marks,
                                        const Eigen::Vector2i& size_px, double sigma0_px);

}  // namespace adit::host
