#include "host/target_design.h"

#include <array>
#include <cmath>

#include "firmware/identify/identifier.h"
#include "firmware/stereo/locator.h"
#include "host/training.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::Target;
using adit::host::DesignOrder;
using adit::host::DesignTargets;
using adit::host::DirectionSigmas;
using adit::host::DistinctUpToM;
using adit::host::NeededSigmas;
using adit::host::SeparationSigmas;
using adit::host::ViewConditions;

DesignOrder OneMetreAt110() {
  DesignOrder order;
  order.length_m = 1, order.distance_m = 110, order.view.noise_px = 0.05;
  return order;
}

Target Bar(double led2_m, double led3_m, double length_m) {
  return {"bar", {0, led2_m, led3_m, length_m}, 0, 0.04};
}

}  // namespace

TEST_GROUP(TargetDesign){};

TEST(TargetDesign, SeparatesABarFromItselfByNothing) {
  for (const double distance_m : {5.0, 30.0, 110.0})
    DOUBLES_EQUAL(0, SeparationSigmas(Bar(0.25, 0.65, 1.5), Bar(0.25, 0.65, 1.5), distance_m, {}), 0.05);
}

// Far away perspective is nothing: the least-squares distance of two layouts of one length is then known. One
// inner LED moved by d leaves d sqrt(1 - 1/4 - (u - mean)^2 / sum (u - mean)^2).
TEST(TargetDesign, MeasuresFarLayoutsByTheirAffinePlaces) {
  const ViewConditions across{1e-6, 3378, 0.05};
  const std::array<double, 4> u{0, 0.3, 0.6, 1};
  const double mean = 0.475;
  double sum = 0;
  for (const double place : u) sum += (place - mean) * (place - mean);
  const double moved_px = 0.01 * 3378 / 100, share = std::sqrt(0.75 - (0.3 - mean) * (0.3 - mean) / sum);
  DOUBLES_EQUAL(moved_px * share / 0.05, SeparationSigmas(Bar(0.31, 0.6, 1), Bar(0.3, 0.6, 1), 100, across),
                0.05);
}

TEST(TargetDesign, FindsNoDirectionInASymmetricBar) {
  DOUBLES_EQUAL(0, DirectionSigmas(Bar(0.3, 0.7, 1), 50, {}), 0.05);
  CHECK_COMPARE(DirectionSigmas(Bar(0.25, 0.65, 1.5), 50, {}), >, NeededSigmas(0.05));
}

TEST(TargetDesign, SaysUpToWhereTwoTargetsAreDistinct) {
  const auto far = DistinctUpToM(Bar(0.25, 0.65, 1.5), Bar(0.25, 0.80, 1.5), 5, 110, {});
  const auto near = DistinctUpToM(Bar(0.25, 0.65, 1.5), Bar(0.25, 0.67, 1.5), 5, 110, {});
  const auto never = DistinctUpToM(Bar(0.25, 0.65, 1.5), Bar(0.25, 0.6501, 1.5), 5, 110, {});
  DOUBLES_EQUAL(110, *far, 0);
  CHECK(near.has_value());
  CHECK_COMPARE(*near, >, 10);
  CHECK_COMPARE(*near, <, 109);
  CHECK_FALSE(never.has_value());
  CHECK_COMPARE(SeparationSigmas(Bar(0.25, 0.65, 1.5), Bar(0.25, 0.67, 1.5), *near, {}), >=,
                NeededSigmas(0.05));
}

TEST(TargetDesign, KeepsItsPromisesOnPaper) {
  const DesignOrder order = OneMetreAt110();
  const auto design = DesignTargets(order);
  CHECK(bool(design));
  CHECK_COMPARE(design->fitting, >=, 15);
  LONGS_EQUAL(design->fitting, design->targets.size());
  CHECK_COMPARE(design->gap_px, >=, 4.75 * 1.5);
  for (std::size_t i = 0; i < design->targets.size(); ++i) {
    const Target& a = design->targets[i];
    for (std::size_t g = 1; g < 4; ++g) {
      CHECK_COMPARE(a.leds_m[g] - a.leds_m[g - 1], >=, design->gap_m - 1e-9);
      DOUBLES_EQUAL(0, std::remainder(a.leds_m[g], 0.01), 1e-9);
    }
    CHECK_COMPARE(DirectionSigmas(a, 110, order.view), >=, design->needed_sigmas);
    for (std::size_t j = 0; j < i; ++j)
      CHECK_COMPARE(SeparationSigmas(a, design->targets[j], 110, order.view), >=,
                    design->separation_sigmas * 0.99);
  }
}

// The proof on made centroids: 15 bars of 1 m at 110 m, leaning up to 20 degrees, every one looked for in
// every pair among all 15 models. Nothing may be reported as another bar, and hardly any may be missed.
TEST(TargetDesign, FifteenBarsOfOneMetreAreToldApartAt110m) {
  DesignOrder order = OneMetreAt110();
  order.count = 15;
  const auto design = DesignTargets(order);
  CHECK(bool(design));
  LONGS_EQUAL(15, design->targets.size());
  adit::host::TrainingOptions training;
  training.tilt_max_rad = order.view.tilt_max_rad;
  std::vector<adit::identify::Model> models;
  for (const Target& target : design->targets) models.push_back(GeometryModel(target, training));

  const auto rig = adit::support::ToedInRig();
  adit::identify::IdentifierOptions options;
  options.focal_px = 3378;
  adit::identify::Identifier identifier(models, options);
  adit::stereo::Locator locator(rig.AsRig(), design->targets);
  adit::support::SyntheticScene scene(rig, 17);
  adit::identify::SightingSet left, right;
  adit::stereo::PointSet points;
  int found = 0, wrong = 0, shown = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const auto which = static_cast<std::size_t>(trial) % design->targets.size();
    const double lean = scene.Uniform(-1, 1) * order.view.tilt_max_rad, turn = scene.Uniform(0, 6.283);
    const Eigen::Vector3d direction(std::cos(lean) * std::cos(turn), std::cos(lean) * std::sin(turn),
                                    std::sin(lean));
    scene.Clear();
    const Eigen::Vector3d place =
        Ahead(rig, 110) + Eigen::Vector3d(scene.Uniform(-3, 3), scene.Uniform(-2, 2), 0);
    if (!scene.AddBar(adit::support::SyntheticBar::At(design->targets[which], place, direction), 0.05))
      continue;
    scene.Shuffle();
    ++shown;
    identifier.Identify(scene.Blobs().left, left);
    identifier.Identify(scene.Blobs().right, right);
    locator.Locate(left, right, points);
    for (const auto& target : points.targets) {
      const bool is_found = target.status == adit::stereo::FixStatus::kTracked;
      found += is_found && target.target == which ? 1 : 0;
      wrong += is_found && (target.target != which || target.direction_b.dot(direction) < 0) ? 1 : 0;
    }
  }
  CHECK_COMPARE(shown, >, 590);
  LONGS_EQUAL(0, wrong);
  // The pair's gate on the gaps in 3D takes their noise as linear; at 110 m depth noise bends a gap of 0.25
  // m.
  CHECK_COMPARE(found, >=, shown * 95 / 100);
}

TEST(TargetDesign, RefusesWhatDoesNotFit) {
  DesignOrder order = OneMetreAt110();
  order.count = 60;
  const auto many = DesignTargets(order);
  CHECK_FALSE(many);
  STRCMP_CONTAINS("is more than fit", many.error().Line().c_str());
  order.count = 0, order.length_m = 0.5;
  const auto close = DesignTargets(order);
  CHECK_FALSE(close);
  STRCMP_CONTAINS("holds no four LEDs", close.error().Line().c_str());
  LONGS_EQUAL(1, close.error().ExitCode());
}

TEST(TargetDesign, IsListedInWholeCentimetres) {
  DesignOrder order = OneMetreAt110();
  order.distance_m = 60, order.count = 3;
  const auto design = DesignTargets(order);
  const std::string text = FormatDesign(*design, order);
  STRCMP_CONTAINS("bar_03  leds_m: [0.00, ", text.c_str());
  STRCMP_CONTAINS(", 1.00]", text.c_str());
}
