#include "host/comparison.h"

#include <cmath>

#include "host/evaluate_report.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Compare;
using adit::host::Comparison;
using adit::host::Figures;
using adit::pipeline::TrackRow;
using adit::sim::TruthRow;
using Eigen::Vector3d;

constexpr adit::base::TimeNs kFrameNs = 16'666'667;

TruthRow True(int frame, double z_m, const std::string& target = "bar") {
  TruthRow row;
  row.mid_exposure_ns = frame * kFrameNs;
  row.target = target;
  row.epicenter_m = Vector3d(0, 0, z_m);
  row.leds_m = {Vector3d(0, 0, z_m), Vector3d(0.25, 0, z_m), Vector3d(0.65, 0, z_m), Vector3d(1.5, 0, z_m)};
  row.visible = 4;
  return row;
}

TrackRow Found(const TruthRow& truth, const Vector3d& error_m = Vector3d::Zero()) {
  TrackRow row;
  row.timestamp_ns = truth.mid_exposure_ns;
  row.target = truth.target;
  row.status = adit::stereo::FixStatus::kTracked;
  row.position_m = truth.epicenter_m + error_m;
  row.sigma_m = Vector3d::Constant(0.001);
  row.direction = truth.direction;
  row.bar_m = 1.5;
  return row;
}

/// The figures of a target in the range that starts at `from_m` and ends at `to_m`.
Figures Of(const Comparison& comparison, double from_m, double to_m) {
  for (const Figures& f : comparison.figures) {
    if (f.from_m == from_m && f.to_m == to_m) return f;
  }
  FAIL("no such range");
  return {};
}

}  // namespace

TEST_GROUP(Comparison){};

TEST(Comparison, KnowsErrorsOfKnownTracks) {
  const std::vector<TruthRow> truth{True(0, 25), True(1, 25), True(2, 60), True(3, 60)};
  std::vector<TrackRow> track{Found(truth[0], {0.003, 0, 0}), Found(truth[1], {0, -0.004, 0}),
                              Found(truth[2], {0, 0, 0.002})};
  track[0].bar_m = 1.502, track[1].bar_m = 1.497;
  track[2].direction = -Vector3d::UnitX();

  const auto comparison = *Compare(track, truth, 4);

  const Figures near = Of(comparison, 20, 30), far = Of(comparison, 50, 80), all = Of(comparison, 0, 1000);
  DOUBLES_EQUAL(100, near.TrackedPct(), 1e-9);
  DOUBLES_EQUAL(50, far.TrackedPct(), 1e-9);
  DOUBLES_EQUAL(75, all.TrackedPct(), 1e-9);
  DOUBLES_EQUAL(std::sqrt(12.5e-6), near.rms_m, 1e-12);  // (9 + 16) / 2 mm^2
  DOUBLES_EQUAL(0.004, near.max_m, 1e-12);
  DOUBLES_EQUAL(0.0015, near.bias_m.x(), 1e-12);
  DOUBLES_EQUAL(-0.002, near.bias_m.y(), 1e-12);
  DOUBLES_EQUAL(12.5, near.nees, 1e-9);
  DOUBLES_EQUAL(0.0025, near.bar_mae_m, 1e-12);
  // half of | 1.5 - sqrt((1.502^2 + 1.497^2) / 2) |
  DOUBLES_EQUAL(0.000248958, near.bar_xrms_m, 1e-8);
  LONGS_EQUAL(0, near.flips);
  LONGS_EQUAL(1, far.flips);
  LONGS_EQUAL(0, comparison.false_positions);
}

TEST(Comparison, CountsPositionsThatTheTruthDoesNotHold) {
  const std::vector<TruthRow> truth{True(0, 25)};
  const std::vector<TrackRow> track{Found(True(0, 25)), Found(True(1, 25)), Found(True(0, 25, "ghost"))};
  LONGS_EQUAL(2, Compare(track, truth, 4)->false_positions);
}

TEST(Comparison, LeavesHiddenTargetsOutOfTheErrors) {
  std::vector<TruthRow> truth{True(0, 25), True(1, 25)};
  truth[1].visible = 3;
  const std::vector<TrackRow> track{Found(truth[0]), Found(truth[1], {1, 0, 0})};

  const Figures all = Of(*Compare(track, truth, 4), 0, 1000);

  LONGS_EQUAL(1, all.visible);
  LONGS_EQUAL(1, all.hidden);
  DOUBLES_EQUAL(0, all.rms_m, 1e-12);
  LONGS_EQUAL(2, Of(*Compare(track, truth, 3), 0, 1000).visible);
}

TEST(Comparison, DoesNotPairNeighbouringFrames) {
  auto late = Found(True(0, 25));
  late.timestamp_ns += 2'000'000;
  const auto comparison = *Compare({late}, {True(0, 25)}, 4);
  LONGS_EQUAL(0, Of(comparison, 0, 1000).tracked);
  LONGS_EQUAL(1, comparison.false_positions);
}

TEST(Comparison, ATargetWithoutPositionsHasNoErrorsInsteadOfSmallOnes) {
  const auto comparison = *Compare({Found(True(0, 25))}, {True(0, 25), True(0, 25, "missed")}, 4);
  const Figures& missed = comparison.figures.back();
  STRCMP_EQUAL("missed", missed.target.c_str());
  CHECK(std::isnan(missed.rms_m) && std::isnan(missed.max_m) && std::isnan(missed.nees));
  CHECK(std::isnan(missed.bias_m.x()) && std::isnan(missed.bar_mae_m) && std::isnan(missed.bar_xrms_m));
  STRCMP_CONTAINS("0.00        -        -      -      -      -       -", FormatTable(comparison).c_str());
  STRCMP_CONTAINS("\"rms_m\": null, \"max_m\": null", FormatJson(comparison).c_str());
  const auto page = adit::host::MakeEvaluateReport(comparison, "track.csv", "truth.csv");
  STRCMP_CONTAINS("missed: 1 of 1 times without a position", page.Html().c_str());
}

TEST(Comparison, DeclinesWhenThereIsNothingToCompare) {
  CHECK_FALSE(Compare({}, {}, 4));
  CHECK_FALSE(Compare({}, {}, 4).error().ExitCode() == 0);
}

TEST(Comparison, TakesLostAndPredictedRowsForNoPosition) {
  std::vector<TrackRow> track{Found(True(0, 25)), Found(True(1, 25)), Found(True(2, 25))};
  track[0].status = adit::stereo::FixStatus::kLost;
  track[1].status = adit::stereo::FixStatus::kPredicted;
  track[2].status = adit::stereo::FixStatus::kRecovered;

  const auto comparison = *Compare(track, {True(0, 25), True(1, 25), True(2, 25)}, 4);

  LONGS_EQUAL(1, Of(comparison, 0, 1000).tracked);
  LONGS_EQUAL(1, Of(comparison, 0, 1000).recovered);
  LONGS_EQUAL(0, comparison.false_positions);
}
