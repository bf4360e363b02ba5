#include "host/coverage_gap.h"

#include <vector>

#include "host/simulated_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CoverageGap;
using adit::host::CoverageGaps;
using adit::host::StereoBar;
using adit::optics::RigCovariance;
using Eigen::Vector2d;

const adit::host::TrueRig kTruth = adit::host::MakeTrueRig(9, 35);

/// Known but for the yaw.
RigCovariance YawAlone() {
  RigCovariance covariance = RigCovariance::Zero();
  covariance(1, 1) = 30e-6 * 30e-6;
  return covariance;
}

/// Bars in the middle of every ninth of cam0's image at 20, 45, 75 and 105 m, but for what is left out.
struct Everywhere {
  std::vector<StereoBar> bars;
  std::vector<double> distances_m;

  explicit Everywhere(const Vector2d& left_out, double left_out_m) {
    for (const double distance_m : {20.0, 45.0, 75.0, 105.0}) {
      for (int i = 0; i < 9; ++i) {
        const Vector2d ninth(i % 3, i / 3);  // NOLINT(bugprone-integer-division): column and row
        if (ninth == left_out && distance_m == left_out_m) continue;
        StereoBar bar;
        for (auto& led : bar.left)
          led.raw_px = (ninth + Vector2d(0.5, 0.5)).cwiseProduct(Vector2d(1400, 1024) / 3);
        for (int k = 0; k < 2; ++k) bars.push_back(bar), distances_m.push_back(distance_m);
      }
    }
  }
};

}  // namespace

TEST_GROUP(CoverageGap){};

TEST(CoverageGap, IsSaidInWords) {
  STRCMP_EQUAL("lower left, 60 to 90 m", (CoverageGap{0, 2, 60, 90}.Words().c_str()));
  STRCMP_EQUAL("upper middle, 10 to 30 m", (CoverageGap{1, 0, 10, 30}.Words().c_str()));
  STRCMP_EQUAL("middle, 30 to 60 m", (CoverageGap{1, 1, 30, 60}.Words().c_str()));
  STRCMP_EQUAL("right, 90 to 120 m", (CoverageGap{2, 1, 90, 120}.Words().c_str()));
}

TEST(CoverageGap, TheOnlyPlaceLeftOutIsNamed) {
  const Everywhere seen({1, 2}, 75);
  const auto gaps = CoverageGaps(kTruth.AsRig(), YawAlone(), {seen.bars, seen.distances_m}, 0.01);
  LONGS_EQUAL(1, gaps.size());
  STRCMP_EQUAL("lower middle, 60 to 90 m", gaps[0].Words().c_str());
  const Everywhere all({-1, -1}, 0);
  CHECK(CoverageGaps(kTruth.AsRig(), YawAlone(), {all.bars, all.distances_m}, 0.01).empty());
}

TEST(CoverageGap, BothCamerasSeeEveryPlaceThatIsNamed) {
  const auto gaps = CoverageGaps(kTruth.AsRig(), YawAlone(), {}, 0.01);
  CHECK_COMPARE(gaps.size(), >, 12);
  CHECK_COMPARE(gaps.size(), <, 36);  // at 20 m half of cam0's view is not cam1's
  for (const CoverageGap& gap : gaps) {
    const double z_m = 0.5 * (gap.nearest_m + gap.farthest_m);
    const Eigen::Vector3d middle_m(z_m * (gap.column - 1) * 1400 / 3 / 3378,
                                   z_m * (gap.row - 1) * 1024 / 3 / 3378, z_m);
    const Vector2d right_px = kTruth.Project(middle_m).tail<2>();
    constexpr double kSlackPx = 30;  // the distance is along the ray, not the axis
    CHECK(right_px.x() > -kSlackPx && right_px.x() < 1400 + kSlackPx);
    CHECK(right_px.y() > -kSlackPx && right_px.y() < 1024 + kSlackPx);
  }
}

TEST(CoverageGap, TheMostTellingPlaceComesFirst) {
  const auto gaps = CoverageGaps(kTruth.AsRig(), YawAlone(), {}, 0.01);
  for (std::size_t i = 1; i < gaps.size(); ++i)
    CHECK(gaps[i - 1].depth_m / gaps[i - 1].noise_depth_m >= gaps[i].depth_m / gaps[i].noise_depth_m);
}
