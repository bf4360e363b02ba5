#include "firmware/stereo/locator.h"

#include <memory>

#include "firmware/identify/identifier.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;
using Eigen::Vector3d;

namespace {

constexpr double kFocalPx = 3378;

/// Identifier and locator on one synthetic rig.
struct Chain {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  std::vector<adit::base::Target> targets;
  std::unique_ptr<adit::identify::Identifier> identifier;
  std::unique_ptr<adit::stereo::Locator> locator;
  adit::identify::SightingSet left, right;
  adit::stereo::PointSet points;

  explicit Chain(std::vector<adit::base::Target> list) : targets(std::move(list)) {
    std::vector<adit::identify::Model> models;
    for (const auto& target : targets) models.push_back(adit::support::ModelOf(target));
    adit::identify::IdentifierOptions options;
    options.focal_px = kFocalPx;
    identifier = std::make_unique<adit::identify::Identifier>(models, options);
    locator = std::make_unique<adit::stereo::Locator>(rig.AsRig(), targets);
  }
  void Run(const adit::support::BlobPair& blobs) {
    identifier->Identify(blobs.left, left);
    right.blob_set = &blobs.right;
    locator->Locate(left, right, points);
  }
};

Vector3d AheadM(double distance_m) { return {0.128 * distance_m, 0, distance_m}; }

}  // namespace

TEST_GROUP(Locator){};

TEST(Locator, FindsABarAcrossDistancesAndDirectionsAndNeverFlipsIt) {
  Chain chain({adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()});
  auto scene = std::make_unique<SyntheticScene>(chain.rig, 7);
  int seen = 0, found = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    scene->Clear();
    const std::size_t which = trial % 2;
    const double distance_m = scene->Uniform(20, 110);
    const auto bar = SyntheticBar::At(chain.targets[which], AheadM(distance_m), scene->Direction());
    if (!scene->AddBar(bar, 0.02)) continue;
    chain.Run(scene->Blobs());
    const auto& p = chain.points.targets[which];
    const auto px = [&](int i) { return scene->Blobs().left.blobs[i].ideal_px; };
    const double len = (px(3) - px(0)).norm();
    if (len < 12) continue;
    ++seen;
    if (p.status == FixStatus::kTracked) {
      ++found;
      CHECK(p.direction_b.dot(bar.direction_b) > 0.99);
      CHECK((p.epicenter_b_m - bar.Epicenter()).norm() < 0.1);
    }
  }
  CHECK(found > 0.99 * seen);
}
