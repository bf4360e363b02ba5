#include "firmware/identify/identifier.h"

#include <cmath>
#include <limits>
#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

using adit::base::Side;
using adit::base::Target;
using adit::identify::Identifier;
using adit::identify::IdentifierOptions;
using adit::identify::Sighting;
using adit::identify::SightingSet;
using adit::support::ModelOf;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kFocalPx = 3378;
constexpr double kDegree = 3.14159265358979 / 180;

Identifier IdentifierOf(const std::vector<Target>& targets) {
  std::vector<adit::identify::Model> models;
  for (const Target& target : targets) models.push_back(ModelOf(target));
  IdentifierOptions options;
  options.focal_px = kFocalPx;
  return Identifier(models, options);
}

bool Is(const Sighting& s, std::size_t target, const std::array<std::uint16_t, 4>& blobs) {
  return s.target == target && s.blobs == blobs;
}

bool Holds(const SightingSet& set, std::size_t target, const std::array<std::uint16_t, 4>& blobs) {
  for (const Sighting& s : set.sightings) {
    if (Is(s, target, blobs)) return true;
  }
  return false;
}

/// A scene with one camera's view of a bar: the left image alone matters here.
struct OneCamera {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(rig, 3);
  std::unique_ptr<SightingSet> found = std::make_unique<SightingSet>();

  bool AddLeds(const SyntheticBar& bar, double sigma_px) {
    std::array<Vector2d, 4> raw;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto ideal = rig.left.ProjectIdeal(bar.Point(bar.target.leds_m[i]));
      if (!ideal) return false;
      raw[i] = rig.left.Distorted(*ideal);
      if (!rig.left.InImage(raw[i])) return false;
    }
    for (const Vector2d& px : raw) scene->AddBlob(Side::kLeft, px, sigma_px);
    return true;
  }
  double LengthPx(std::size_t first) const {
    const auto& blobs = scene->Blobs().left.blobs;
    return (blobs[first + 3].ideal_px - blobs[first].ideal_px).norm();
  }
};

/// Adds four blobs along a line from `start` to the right at the places given, px.
void AddRow(SyntheticScene& scene, const Vector2d& start, const std::array<double, 4>& places_px) {
  for (const double place_px : places_px) scene.AddBlob(Side::kLeft, start + Vector2d(place_px, 0), 0);
}

}  // namespace

TEST_GROUP(Identifier) { OneCamera camera; };

TEST(Identifier, NeverFlipsABarOverDistancesAndTilts) {
  const std::vector<Target> targets{adit::support::SeedTargetOne(), adit::support::SeedTargetTwo(),
                                    adit::support::ShortTarget()};
  Identifier identifier = IdentifierOf(targets);
  int seen = 0, found = 0;
  for (std::size_t which = 0; which < targets.size(); ++which) {
    for (double distance_m = 5; distance_m <= 110; distance_m *= 1.25) {
      for (int roll = 0; roll < 360; roll += 15) {
        for (int tilt = -80; tilt <= 80; tilt += 10) {
          const double r = roll * kDegree, t = tilt * kDegree;
          const Vector3d direction(std::cos(r) * std::cos(t), std::sin(r) * std::cos(t), std::sin(t));
          camera.scene->Clear();
          const Vector3d middle_m(0.03 * distance_m, -0.02 * distance_m, distance_m);
          if (!camera.AddLeds(SyntheticBar::At(targets[which], middle_m, direction), 0.03)) continue;
          if (camera.LengthPx(0) < 15) continue;
          identifier.Identify(camera.scene->Blobs().left, *camera.found);
          ++seen;
          if (Holds(*camera.found, which, {0, 1, 2, 3})) ++found;
          for (const Sighting& s : camera.found->sightings) {
            if (s.target == which) CHECK_FALSE(s.blobs[0] > s.blobs[3]);
          }
        }
      }
    }
  }
  CHECK(seen > 10000);
  CHECK(found >= 0.999 * seen);
}

TEST(Identifier, HandsOnBothDirectionsOfALayoutThatOneImageCannotTell) {
  const Target nearly_even{"even", {0, 0.49, 0.99, 1.5}, 0, 0.04};
  Identifier identifier = IdentifierOf({nearly_even});
  // At 60 m, tilted: the depth makes up for the difference of the gaps.
  CHECK(camera.AddLeds(SyntheticBar::At(nearly_even, {0, 0, 60}, {0.5, 0, 0.87}), 0.02));
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  CHECK(Holds(*camera.found, 0, {0, 1, 2, 3}));
  CHECK(Holds(*camera.found, 0, {3, 2, 1, 0}));
}

TEST(Identifier, TellsSeveralTargetsApartAmongLamps) {
  const std::vector<Target> targets{adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()};
  Identifier identifier = IdentifierOf(targets);
  std::size_t others = 0;
  for (int trial = 0; trial < 200; ++trial) {
    camera.scene->Clear();
    CHECK(camera.AddLeds(SyntheticBar::At(targets[0], {-4, 0.5, 40}, {0.8, 0.1, 0.3}), 0.03));
    CHECK(camera.AddLeds(SyntheticBar::At(targets[1], {3, -1, 50}, {-0.2, 0.9, -0.3}), 0.03));
    camera.scene->AddLamps(150, 0.03);
    identifier.Identify(camera.scene->Blobs().left, *camera.found);
    CHECK(Holds(*camera.found, 0, {0, 1, 2, 3}));
    CHECK(Holds(*camera.found, 1, {4, 5, 6, 7}));
    LONGS_EQUAL(0, camera.found->no_room);
    CHECK_FALSE(camera.found->cut_short);
    others += camera.found->sightings.size() - 2;
  }
  CHECK(others < 200);  // less than one chance alignment an image
}

TEST(Identifier, SaysWhatItMeasured) {
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne()});
  AddRow(*camera.scene, {600, 500}, {0, 25, 65, 150});
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(1, camera.found->sightings.size());
  const Sighting& s = camera.found->sightings[0];
  DOUBLES_EQUAL(2.2707, static_cast<double>(s.p2), 2e-3);
  DOUBLES_EQUAL(150, static_cast<double>(s.length_px), 1);
  CHECK(static_cast<double>(s.collinearity_px) < 0.05);
  POINTERS_EQUAL(&camera.scene->Blobs().left, camera.found->blob_set);
}

TEST(Identifier, RefusesTheComplementOfTheCrossRatio) {
  // lambda -> 1 - lambda keeps J: a layout with these places has target one's invariant and is another.
  const double lambda = 1 - 0.25 * 0.85 / (1.25 * 0.65);
  // Places 0, a, b, 1 with a (1 - b) / ((1 - a) b) = lambda: b = 0.5 gives a = lambda / (1 + lambda).
  const double a = lambda / (1 + lambda);
  AddRow(*camera.scene, {600, 500}, {0, 150 * a, 75, 150});
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne()});
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(0, camera.found->sightings.size());
}

TEST(Identifier, RefusesARowWhoseNoiseCannotExplainIt) {
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne()});
  AddRow(*camera.scene, {600, 500}, {0, 26.5, 65, 150});  // 1.5 px off along the row
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(0, camera.found->sightings.size());
  camera.scene->Clear();
  AddRow(*camera.scene, {600, 500}, {0, 25, 65, 150});
  camera.scene->Blobs().left.blobs[2].ideal_px.y() += 0.6;  // and across it
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(0, camera.found->sightings.size());
}

TEST(Identifier, KeepsToTheTrainedRanges) {
  adit::identify::Model model = ModelOf(adit::support::SeedTargetOne());
  AddRow(*camera.scene, {600, 500}, {0, 25, 65, 150});
  const auto count = [&] {
    Identifier({model}).Identify(camera.scene->Blobs().left, *camera.found);
    return camera.found->sightings.size();
  };
  LONGS_EQUAL(1, count());
  model.length_min_px = 151;
  LONGS_EQUAL(0, count());
  model.length_min_px = 10, model.length_max_px = 149;
  LONGS_EQUAL(0, count());
  model.length_max_px = 400, model.p2_min = 2.28;
  LONGS_EQUAL(0, count());
  model.p2_min = 2.2, model.p2_max = 2.26;
  LONGS_EQUAL(0, count());
}

TEST(Identifier, ReportsNothingForAFrameThatIsNotUsable) {
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne()});
  AddRow(*camera.scene, {600, 500}, {0, 25, 65, 150});
  camera.scene->Blobs().left.stamp.status = adit::base::FrameStatus::kIncomplete;
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(0, camera.found->sightings.size());
}

TEST(Identifier, PassesOverBlobsThatAreNoNumbers) {
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne()});
  camera.scene->AddLamps(20, 0.1);
  auto& blobs = camera.scene->Blobs().left.blobs;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < 20; i += 4) {
    blobs[i].ideal_px.x() = nan;
    blobs[i + 1].ideal_px.y() = HUGE_VAL;
    blobs[i + 2].covariance_px2(0, 0) = nan;
    blobs[i + 3].covariance_px2(1, 1) = 1e9;
  }
  AddRow(*camera.scene, {600, 500}, {0, 25, 65, 150});
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(1, camera.found->sightings.size());
  CHECK(Holds(*camera.found, 0, {20, 21, 22, 23}));
}

TEST(Identifier, EndsItsSearchInGlitterAndSaysSo) {
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne(), adit::support::ShortTarget()});
  for (std::size_t i = 0; i < adit::detect::kMaxBlobs; ++i) {
    const Vector2d place(700 + camera.scene->Uniform(-40, 40), 500 + camera.scene->Uniform(-40, 40));
    camera.scene->AddBlob(Side::kLeft, place, 0.2);
  }
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  CHECK(camera.found->cut_short || camera.found->no_room > 0);
}

TEST(Identifier, AllocatesNothing) {
  if (!adit::support::CountsAllocations()) return;
  Identifier identifier = IdentifierOf({adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()});
  CHECK(
      camera.AddLeds(SyntheticBar::At(adit::support::SeedTargetOne(), {-4, 0.5, 40}, {0.8, 0.1, 0.3}), 0.03));
  camera.scene->AddLamps(300, 0.03);
  const auto before = adit::support::AllocationCount();
  identifier.Identify(camera.scene->Blobs().left, *camera.found);
  LONGS_EQUAL(before, adit::support::AllocationCount());
  CHECK(!camera.found->sightings.empty());
}
