#include "host/coverage_gap.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace adit::host {
namespace {

constexpr int kNinths = 3;
constexpr std::array<double, 5> kBandsM{10, 30, 60, 90, 120};
constexpr std::size_t kBands = kBandsM.size() - 1;
constexpr int kLedsMin = 8;  // of two bars

bool IsInside(const optics::CameraModel& camera, const Eigen::Vector2d& px) {
  return px.x() >= 0 && px.y() >= 0 && px.x() <= camera.width_px - 1 && px.y() <= camera.height_px - 1;
}

/// LEDs a region.
class LedCounts {
 public:
  LedCounts(const optics::CameraModel& camera, const PlacedBars& placed) {
    for (std::size_t i = 0; i < placed.bars.size(); ++i) {
      const auto band = std::upper_bound(kBandsM.begin(), kBandsM.end(), placed.distances_m[i]);
      if (band == kBandsM.begin() || band == kBandsM.end()) continue;
      for (const LedView& led : placed.bars[i].left) {
        const auto ninth = [](double place_px, int size_px) {
          return std::clamp(static_cast<int>((place_px + 0.5) / size_px * kNinths), 0, kNinths - 1);
        };
        ++Of(ninth(led.raw_px.x(), camera.width_px), ninth(led.raw_px.y(), camera.height_px),
             static_cast<std::size_t>(band - kBandsM.begin()) - 1);
      }
    }
  }
  int& Of(int column, int row, std::size_t band) {
    return counts_[(static_cast<std::size_t>(row * kNinths + column)) * kBands + band];
  }

 private:
  std::array<int, kNinths * kNinths * kBands> counts_{};
};

}  // namespace

std::string CoverageGap::Words() const {
  constexpr std::array<const char*, kNinths> kRows{"upper", "", "lower"}, kColumns{"left", "middle", "right"};
  const std::string above = kRows[static_cast<std::size_t>(row)];
  return above + (above.empty() ? "" : " ") + kColumns[static_cast<std::size_t>(column)] + ", " +
         std::to_string(std::lround(nearest_m)) + " to " + std::to_string(std::lround(farthest_m)) + " m";
}

std::vector<CoverageGap> CoverageGaps(const optics::Rig& rig, const optics::RigCovariance& covariance,
                                      const PlacedBars& placed, double noise_px) {
  LedCounts counts(rig.left, placed);
  std::vector<CoverageGap> gaps;
  for (std::size_t i = 0; i < kNinths * kNinths * kBands; ++i) {
    const std::size_t band = i % kBands;
    const int column = static_cast<int>(i / kBands) % kNinths, row = static_cast<int>(i / kBands) / kNinths;
    if (counts.Of(column, row, band) >= kLedsMin) continue;
    const auto middle_px = rig.left.Undistort({rig.left.width_px * (column + 0.5) / kNinths - 0.5,
                                               rig.left.height_px * (row + 0.5) / kNinths - 0.5});
    if (!middle_px) continue;
    const double distance_m = 0.5 * (kBandsM[band] + kBandsM[band + 1]);
    const Eigen::Vector3d middle_m = distance_m * rig.left.Normalised(*middle_px).homogeneous().normalized();
    const auto right_px = rig.right.Project(rig.T_r_l * middle_m);
    if (!right_px || !IsInside(rig.right, *right_px)) continue;
    const auto there = PredictAt(rig, covariance, middle_m, noise_px);
    if (!there) continue;
    gaps.push_back({column, row, kBandsM[band], kBandsM[band + 1], there->depth_m, there->noise_depth_m});
  }
  std::stable_sort(gaps.begin(), gaps.end(), [](const CoverageGap& a, const CoverageGap& b) {
    return a.depth_m * b.noise_depth_m > b.depth_m * a.noise_depth_m;
  });
  return gaps;
}

}  // namespace adit::host
