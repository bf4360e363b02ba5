#include "host/seed_tables.h"

#include <cmath>
#include <string>

#include "host/seed_campaign.h"
#include "host/tunnel.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::BarPose;
using adit::host::BoundAt;
using adit::host::MiddleFrame;
using adit::host::SeedCampaign;
using adit::host::SeedCell;
using adit::host::SeedDraw;
using adit::host::SeedSetup;
using adit::host::SeedTable;
using adit::host::TunnelRig;
using adit::host::WandBound;
using adit::optics::RigCovariance;
using Eigen::Vector3d;

const adit::base::Target kShort{"short", {0, 0.20, 0.47, 0.82}, 0.41, 0.04};
const adit::base::Target kLong{"long", {0, 0.25, 0.65, 1.50}, 0.6, 0.04};

std::vector<BarPose> AtRest(const adit::optics::Rig& rig, double distance_m, std::size_t frames) {
  const MiddleFrame middle(rig);
  const Vector3d across = middle.R_b_m.col(0);
  return std::vector<BarPose>(frames, {middle.InRig({0, 0, distance_m}) - 0.75 * across, across});
}

SeedTable OneTable() {
  SeedTable table{"5.9", "Something", "how <it> was", {}, 100, 1};
  SeedCell good{"a_mm", "a", 5, 1, 1.1, 1.2, "1.2 x bound"},
      free{"b_mm", "b", SeedCell::kNone, 2, 9, SeedCell::kNone, ""};
  table.rows.push_back({30, "base 6 m", {good, free}});
  table.rows.push_back({50, "base 6 m", {good, free}});
  return table;
}

}  // namespace

TEST_GROUP(SeedTables){};

// 1100 frames of a 0.82 m bar at 15 to 30 m with 0.05 px leave, by an independent computation of the same
// kind, pitch / yaw / roll of 1.9 / 30 / 3.8 microradians and 0.74 mm of baseline (base 9 m).
TEST(SeedTables, TheWandBoundIsWhatOthersComputed) {
  const auto rig = TunnelRig(9);
  const SeedSetup setup{9, 35, kShort, 15, 30, 1100, 0, 0.05};
  SeedDraw draw(1, 1);
  std::vector<BarPose> poses;
  for (std::size_t i = 0; i < setup.frames; ++i) poses.push_back(draw.Wave(rig, setup, 1));

  const RigCovariance bound = WandBound(rig, setup, poses);

  DOUBLES_EQUAL(1.9e-6, std::sqrt(bound(0, 0)), 0.4e-6);
  DOUBLES_EQUAL(30e-6, std::sqrt(bound(1, 1)), 6e-6);
  DOUBLES_EQUAL(3.8e-6, std::sqrt(bound(2, 2)), 0.8e-6);
  const Vector3d t = rig.T_r_l.translation_m.normalized();
  DOUBLES_EQUAL(0.74e-3, std::sqrt(t.dot(bound.block<3, 3>(3, 3) * t)), 0.15e-3);
}

// By another computation a single LED has 1.17 mm of depth noise at 50 m and 0.01 px, a length 0.96 mm for
// random directions and sqrt 2 of 0.0021 Z for one across the view; the middle of a rigid bar half of it.
TEST(SeedTables, ThePlaceBoundIsWhatOthersComputed) {
  const auto rig = TunnelRig(9);
  const auto bound = BoundAt(rig, RigCovariance::Zero(), kLong, AtRest(rig, 50, 2), 0.01);
  DOUBLES_EQUAL(0.5 * 1.17e-3, bound.sigma_m.z(), 0.06e-3);
  DOUBLES_EQUAL(std::sqrt(2) * 0.0021 * 50e-3, bound.bar_sigma_m, 0.01e-3);
  DOUBLES_EQUAL(0.5 * 0.0021 * 50e-3, bound.sigma_m.y(), 0.01e-3);
}

// A rig whose translation is 1e-4 too long makes every distance 1e-4 too long.
TEST(SeedTables, AWrongScaleIsSeenInLengthAndDistance) {
  const auto rig = TunnelRig(9);
  RigCovariance scale = RigCovariance::Zero();
  const Vector3d t = rig.T_r_l.translation_m;
  scale.block<3, 3>(3, 3) = 1e-8 * t * t.transpose();
  const auto bound = BoundAt(rig, scale, kLong, AtRest(rig, 50, 2), 1e-6);
  DOUBLES_EQUAL(1e-4 * 1.5, bound.bar_bias_m, 1e-6);
  DOUBLES_EQUAL(0.5e-4 * 1.5, bound.half_bar_m, 1e-6);
}

// Eight small calibrations: what is measured must scatter about the bound. One draw of eight rms's of one
// degree of freedom lies within 0.5 to 1.6 of its truth in 98 %.
TEST(SeedTables, ACampaignMeasuresWhatItsBoundSays) {
  const SeedSetup setup{9, 35, kLong, 15, 30, 250, 1e-4, 0.0084};
  const auto campaign = SeedCampaign::Run(setup, 8, 3);
  CHECK(bool(campaign));
  const auto c = campaign->Measure({kLong, AtRest(campaign->Truth(), 60, 150)});
  LONGS_EQUAL(8 * 150, c.measured.frames);
  LONGS_EQUAL(0, c.measured.lost);
  DOUBLES_EQUAL(1, c.measured.sigma_m.z() / c.bound.sigma_m.z(), 0.1);
  DOUBLES_EQUAL(1, c.measured.bar_sigma_m / c.bound.bar_sigma_m, 0.1);
  CHECK_COMPARE(c.measured.position_m / c.bound.position_m, >, 0.5);
  CHECK_COMPARE(c.measured.position_m / c.bound.position_m, <, 1.6);
  CHECK_COMPARE(c.measured.half_bar_m / c.bound.half_bar_m, >, 0.4);
  CHECK_COMPARE(c.measured.half_bar_m / c.bound.half_bar_m, <, 1.6);
}

TEST(SeedTables, CountAMovementAsSpread) {
  const auto rig = TunnelRig(9);
  auto poses = AtRest(rig, 30, 100);
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i].led1_b_m += (i % 2 == 0 ? 1e-3 : -1e-3) * MiddleFrame(rig).R_b_m.col(1);
  const auto bound = BoundAt(rig, RigCovariance::Zero(), kLong, poses, 1e-5);
  DOUBLES_EQUAL(1e-3, bound.sigma_m.y(), 1e-5);
}

TEST(SeedTables, SayWhatIsMissed) {
  SeedTable table = OneTable();
  CHECK(table.Holds());
  table.rows[1].cells[0].measured_mm = 1.3;
  CHECK_FALSE(table.Holds());
  STRCMP_CONTAINS("MISSED a_mm: 1.2 x bound", FormatSeedTable(table).c_str());
  STRCMP_CONTAINS("1 of 2 limits held; 1 of 100 frames lost", FormatSeedTable(table).c_str());
  table.rows[1].cells[0].measured_mm = SeedCell::kNone;  // nothing was found
  CHECK_FALSE(table.Holds());
}

TEST(SeedTables, StandBesideTheThesisOnOnePage) {
  const auto page = adit::host::MakeSeedReport({OneTable()}, {});
  STRCMP_CONTAINS("Simulation is not a tunnel", page.Html().c_str());
  STRCMP_CONTAINS("how &lt;it&gt; was", page.Html().c_str());
  STRCMP_CONTAINS("\"a_mm_thesis\": 5, \"a_mm_bound\": 1, \"a_mm\": 1.1", page.Json().c_str());
  STRCMP_CONTAINS("\"b_mm_thesis\": null", page.Json().c_str());
  CHECK(page.Html().find("nan") == std::string::npos);
}
