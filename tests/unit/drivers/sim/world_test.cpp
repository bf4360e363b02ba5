#include "drivers/sim/world.h"

#include <cmath>
#include <numbers>

#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::base::Side;
using adit::sim::kAllShown;
using adit::sim::LedView;
using adit::sim::TargetTruth;
using adit::sim::World;
using adit::tests::kBarBuild;
using adit::tests::kBarKeys;
using adit::tests::kSmallRig;
using adit::tests::SceneOf;
using Eigen::Vector3d;

namespace {

const std::string kBar = kBarKeys + ", epicenter_m: 1.5, at_m: [0.1, 0.2, 20], direction: [0.6, 0, 0.8]";
const std::string kFrontBar = kBarKeys + ", at_m: [0, 0, 20]";

std::string With(const std::string& bar, const std::string& more = "") {
  return kSmallRig + "targets: [{" + bar + "}]\n" + more;
}

void CheckViews(const World& world, std::uint64_t trigger, Side side, std::array<LedView, 4> expected) {
  const TargetTruth truth = world.TruthAt(trigger).front();
  for (std::size_t i = 0; i < 4; ++i)
    LONGS_EQUAL(static_cast<int>(expected[i]),
                static_cast<int>(truth.views[static_cast<std::size_t>(side)][i]));
}

void CheckNear(const Vector3d& expected, const Vector3d& actual) {
  for (int i = 0; i < 3; ++i) DOUBLES_EQUAL(expected[i], actual[i], 1e-12);
}

constexpr auto kSeen = LedView::kVisible;

}  // namespace

TEST_GROUP(World){};

TEST(World, KnowsWhereABarAtRestIs) {
  const World world(SceneOf(With(kBar)));
  const auto truths = world.TruthAt(17);
  LONGS_EQUAL(1, truths.size());
  CheckNear({0.6, 0, 0.8}, truths[0].direction);
  CheckNear({0.1 + 0.9, 0.2, 20 + 1.2}, truths[0].epicenter_m);
  CheckNear({0.1, 0.2, 20}, truths[0].leds_m[0]);
  CheckNear({0.1 + 0.6, 0.2, 20 + 0.8}, truths[0].leds_m[2]);
  LONGS_EQUAL(4, truths[0].Visible());
}

TEST(World, CarriesTheBarsOfAMachineWithIt) {
  const World world(SceneOf(kSmallRig +
                            "rate_hz: 1\nexposure_s: 0.002\nmachines: [{path: {waypoints: [{t_s: 0, at_m: "
                            "[0, 0, 20]}, {t_s: 10, at_m: [0, 0, 30]}]}, targets: [{" +
                            kBarKeys + ", at_m: [0.5, -0.5, 1], direction: [-1, 0, 0]}]}]\n"));
  CheckNear({0.5, -0.5, 21 + 5 + 0.001}, world.TruthAt(5).front().leds_m[0]);
  CheckNear({-1.5, -0.5, 21 + 5 + 0.001}, world.TruthAt(5).front().leds_m[3]);
}

TEST(World, DatesTriggersAndMiddlesOfExposures) {
  const World world(SceneOf(With(kBar, "rate_hz: 60\nexposure_s: 0.004\nstart_s: 1000\n")));
  LONGLONGS_EQUAL(1'000'000'000'000, world.TriggerNs(0));
  LONGLONGS_EQUAL(1'000'002'000'000, world.MidExposureNs(0));
  LONGLONGS_EQUAL(1'000'016'666'667, world.TriggerNs(1));
  LONGLONGS_EQUAL(1'001'000'000'000, world.TriggerNs(60));
  LONGLONGS_EQUAL(1'000'000'000'000 + 3600LL * 1'000'000'000, world.TriggerNs(216'000));
  DOUBLES_EQUAL(1.002, world.MidExposureS(60), 1e-12);
}

TEST(World, GivesALightItsPlaceSizeAndFluxInEachCamera) {
  const World world(SceneOf(kSmallRig + "lamps: [{at_m: [0, 1, 20], diameter_m: 0.5, surface_dn: 40}]\n"));
  const auto left = world.Receive(0, Side::kLeft, 0);
  const double distance_m = std::hypot(20.0, 1.0);
  DOUBLES_EQUAL(159.5, left->disc.x_px, 1e-9);
  DOUBLES_EQUAL(119.5 + 40, left->disc.y_px, 1e-9);
  DOUBLES_EQUAL(800 * 0.25 / distance_m, left->disc.radius_px, 1e-9);
  DOUBLES_EQUAL(40 * std::numbers::pi * std::pow(left->disc.radius_px, 2), left->disc.flux_dn, 1e-9);
  CHECK_TRUE(left->shown == kAllShown);
  // The right camera stands at 1 m cos(toe) to the right and 1 m sin(toe) ahead, turned 2 toe to the left.
  const double toe_rad = std::atan2(0.5, 20.0);
  const double x_m = -std::cos(toe_rad), z_m = 20 - std::sin(toe_rad);
  const double bearing_rad = std::atan2(x_m, z_m) + 2 * toe_rad;
  DOUBLES_EQUAL(159.5 + 800 * std::tan(bearing_rad), world.Receive(0, Side::kRight, 0)->disc.x_px, 1e-9);
}

TEST(World, DimsByFog) {
  const std::string lamp = "lamps: [{at_m: [0, 0, 20], diameter_m: 0.5, surface_dn: 40}]\n";
  const World clear(SceneOf(kSmallRig + lamp));
  const World foggy(SceneOf(kSmallRig + lamp + "fog: {per_m: 0.05}\n"));
  DOUBLES_EQUAL(
      std::exp(-1.0),
      foggy.Receive(0, Side::kLeft, 0)->disc.flux_dn / clear.Receive(0, Side::kLeft, 0)->disc.flux_dn, 1e-9);
}

TEST(World, MakesAnLedPeakAsAsked) {
  // 24 mm at 20 m and f = 800 px: a radius of 0.48 px.
  const World world(SceneOf(With(kBarBuild + ", at_m: [0, 0, 20], peak_dn: 150, reference_m: 20")));
  DOUBLES_EQUAL(150, world.Painter().Value(world.Receive(0, Side::kLeft, 0)->disc, 0), 0.3);
}

TEST(World, ExposesAutomaticallyWithinItsLimits) {
  const std::string automatic =
      "exposure_s: 0.001\nauto_exposure: {peak_dn: 200, shortest_s: 0.0005, longest_s: 0.004}\n";
  const World world(
      SceneOf(With(kBarBuild + ", at_m: [0, 0, 20], peak_dn: 100, reference_m: 20", automatic)));
  DOUBLES_EQUAL(2, world.ExposureFactor(0), 0.01);
  const World dark(SceneOf(With(kBarBuild + ", at_m: [0, 0, 20], peak_dn: 10, reference_m: 20", automatic)));
  DOUBLES_EQUAL(4, dark.ExposureFactor(0), 1e-12);
  const World bright(
      SceneOf(With(kBarBuild + ", at_m: [0, 0, 20], peak_dn: 900, reference_m: 20", automatic)));
  DOUBLES_EQUAL(0.5, bright.ExposureFactor(0), 1e-12);
  const World empty(SceneOf(kSmallRig + automatic));
  DOUBLES_EQUAL(1, empty.ExposureFactor(0), 0);
}

TEST(World, SeesAnLedThatIsOff) {
  const World world(SceneOf(With(kFrontBar + ", off: [{led: 2, from_s: 1, to_s: 2}]", "rate_hz: 10\n")));
  CheckViews(world, 9, Side::kLeft, {kSeen, kSeen, kSeen, kSeen});
  CheckViews(world, 10, Side::kLeft, {kSeen, LedView::kOff, kSeen, kSeen});
  CheckViews(world, 15, Side::kRight, {kSeen, LedView::kOff, kSeen, kSeen});
  LONGS_EQUAL(3, world.TruthAt(15).front().Visible());
  CheckViews(world, 20, Side::kLeft, {kSeen, kSeen, kSeen, kSeen});
}

TEST(World, SeesWhatLeavesTheImage) {
  // The left image's right border is at x = (319 - 159.5) / 800 * 20 = 3.99 m.
  const World world(SceneOf(With(kBarKeys + ", at_m: [2.2, 0, 20]")));
  CheckViews(world, 0, Side::kLeft, {kSeen, kSeen, kSeen, LedView::kOutside});
  const World behind(SceneOf(With(kBarKeys + ", at_m: [0, 0, -20]")));
  LONGS_EQUAL(0, behind.TruthAt(0).front().Visible());
}

TEST(World, SeesWhatAPlateHidesFromEachCamera) {
  // Halfway: x = 1 m is before LED 4 (2 m) as the left camera sees it, before LED 3 (1 m) for the right one,
  // which stands at 1 m.
  const World world(
      SceneOf(With(kFrontBar,
                   "occluders: [{at_m: [1, 0, 10], width_m: 0.2, height_m: 0.5, from_s: -1, to_s: 1}]\n"
                   "rate_hz: 1\n")));
  CheckViews(world, 0, Side::kLeft, {kSeen, kSeen, kSeen, LedView::kHidden});
  CheckViews(world, 0, Side::kRight, {kSeen, kSeen, LedView::kHidden, kSeen});
  LONGS_EQUAL(2, world.TruthAt(0).front().Visible());
  LONGS_EQUAL(4, world.TruthAt(1).front().Visible());  // gone after a second
}

TEST(World, DoesNotHideWhatStandsBeforeThePlate) {
  const World world(SceneOf(With(kFrontBar, "occluders: [{at_m: [0, 0, 20.1], width_m: 5, height_m: 5}]\n")));
  LONGS_EQUAL(4, world.TruthAt(0).front().Visible());
}

TEST(World, HidesTheShareOfADiscThatThePlateCovers) {
  // A lamp of 1 m; the plate's edge cuts it through the middle, as seen from the left camera.
  const World world(SceneOf(kSmallRig + "lamps: [{at_m: [0, 0, 20], diameter_m: 1}]\n"
                                        "occluders: [{at_m: [1, 0, 10], width_m: 2, height_m: 4}]\n"));
  const double shown = std::popcount(world.Receive(0, Side::kLeft, 0)->shown);
  DOUBLES_EQUAL(37 / 2.0, shown, 2);
}

TEST(World, FindsLedsCrowdedByALamp) {
  const std::string lamp = "lamps: [{diameter_m: 0.1, surface_dn: 500, at_m: ";
  // The lamp stands 8 px beside LED 4, or well above.
  const World near(SceneOf(With(kFrontBar, lamp + "[2.2, 0, 20]}]\n")));
  CheckViews(near, 0, Side::kLeft, {kSeen, kSeen, kSeen, LedView::kCrowded});
  const World far(SceneOf(With(kFrontBar, lamp + "[2, 1, 20]}]\n")));
  CheckViews(far, 0, Side::kLeft, {kSeen, kSeen, kSeen, kSeen});
}

TEST(World, FindsLedsCrowdedByEachOtherFromFarAway) {
  // At 40 m LEDs 1 and 2 stand 8 px apart, 2 and 3 12 px.
  const World world(SceneOf(With(kBarBuild + ", peak_dn: 200, reference_m: 40, at_m: [0, 0, 40]")));
  CheckViews(world, 0, Side::kLeft, {LedView::kCrowded, LedView::kCrowded, kSeen, kSeen});
}

TEST(World, JudgesCrowdingByTheDarknessBetween) {
  // Two lights of the same peak 100 DN: each profile falls to 12 DN at sigma_eff sqrt(2 ln(100 / 12)), with
  // sigma_eff^2 = 1.3^2 + 0.48^2 / 4: 2.724 px. Clear from 2 * 2.724 + 2 = 7.45 px on, that is 0.1862 m.
  for (const double apart_m : {0.180, 0.192}) {
    const std::string place = std::to_string(apart_m);
    const World world(SceneOf(With("name: b, leds_m: [0, " + place +
                                   ", 1, 2], led_diameter_m: 0.024, "
                                   "at_m: [-1, 0, 20], peak_dn: 100, reference_m: 20")));
    const LedView view = apart_m < 0.186 ? LedView::kCrowded : kSeen;
    CheckViews(world, 0, Side::kLeft, {view, view, kSeen, kSeen});
  }
}

TEST(World, MirrorsLightsInWaterThatDoesNotRipple) {
  // The camera 1 m above the water, the lamp 2 m above it and 20 m away: its image is 2 m below the water.
  const World world(SceneOf(kSmallRig + "lamps: [{at_m: [0, -1, 20], diameter_m: 0.2, surface_dn: 100}]\n"
                                        "water: {y_m: 1, reflectivity: 0.25, wobble_rad: 0}\n"));
  LONGS_EQUAL(2, world.LightCount());
  const auto lamp = world.Receive(0, Side::kLeft, 0), image = world.Receive(1, Side::kLeft, 0);
  DOUBLES_EQUAL(119.5 + 800 * 3 / 20.0, image->disc.y_px, 1e-9);
  const auto surface = [](const adit::sim::Disc& disc) {
    return disc.flux_dn / disc.radius_px / disc.radius_px;
  };
  DOUBLES_EQUAL(0.25, surface(image->disc) / surface(lamp->disc), 1e-9);
}

TEST(World, MirrorsOnlyWhereThereIsWater) {
  // The ray meets the water at a third of the way: z = 20 / 3.
  const std::string lamp = "lamps: [{at_m: [0, -1, 20], diameter_m: 0.2, surface_dn: 100}]\n";
  const World before(
      SceneOf(kSmallRig + lamp + "water: {y_m: 1, nearest_m: 6, farthest_m: 7, wobble_rad: 0}\n"));
  CHECK_TRUE(before.Receive(1, Side::kLeft, 0).has_value());
  const World beyond(
      SceneOf(kSmallRig + lamp + "water: {y_m: 1, nearest_m: 8, farthest_m: 30, wobble_rad: 0}\n"));
  CHECK_FALSE(beyond.Receive(1, Side::kLeft, 0).has_value());
  const World above(SceneOf(kSmallRig + lamp + "water: {y_m: -0.5, wobble_rad: 0}\n"));
  CHECK_FALSE(above.Receive(1, Side::kLeft, 0).has_value());
}
