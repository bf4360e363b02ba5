#include <cmath>

#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/stereo/chain.h"

#include <CppUTest/TestHarness.h>

using adit::base::Side;
using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::stereo::TargetPoints;
using adit::stereo_tests::Chain;
using adit::stereo_tests::ErrorSigmas;
using adit::support::AheadM;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// `distance_m` ahead of the middle between the cameras.

void CheckLost(LossReason reason, const TargetPoints& p) {
  CHECK(p.status == FixStatus::kLost);
  LONGS_EQUAL(static_cast<int>(reason), static_cast<int>(p.reason));
  CHECK(p.epicenter_b_m.isZero());
}

}  // namespace

TEST_GROUP(Locator) {
  Chain chain{{adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()}};
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(chain.rig, 7);
  SyntheticBar bar = SyntheticBar::At(adit::support::SeedTargetOne(), AheadM(40), {1, 0.2, 0.3});
};

TEST(Locator, FindsABarAcrossDistancesAndDirectionsAndNeverFlipsIt) {
  int seen = 0, found = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    scene->Clear();
    const std::size_t which = static_cast<std::size_t>(trial % 2);
    const double distance_m = scene->Uniform(20, 110);
    const auto any = SyntheticBar::At(chain.targets[which], AheadM(distance_m), scene->Direction());
    if (!scene->AddBar(any, 0.02)) continue;
    const auto& blobs = scene->Blobs().left.blobs;
    constexpr double kShortestPx = 12;  // below it LEDs merge in any real image
    if ((blobs[3].ideal_px - blobs[0].ideal_px).norm() < kShortestPx) continue;
    scene->Shuffle();
    chain.Run(scene->Blobs());
    ++seen;
    CHECK(chain.points.targets[1 - which].status == FixStatus::kLost);
    const auto& p = chain.points.targets[which];
    if (p.status != FixStatus::kTracked) continue;
    ++found;
    CHECK(p.direction_b.dot(any.direction_b) > 0.99);
    CHECK(ErrorSigmas(p, any) < 6);
  }
  CHECK(seen > 1000);
  CHECK(found >= 0.999 * seen);
}

TEST(Locator, SaysEverythingAboutATarget) {
  CHECK(scene->AddBar(bar, 0.02));
  const auto& p = chain.Run(scene->Blobs());
  CHECK(p.status == FixStatus::kTracked);
  CHECK(p.reason == LossReason::kNone);
  LONGS_EQUAL(0, p.recovered_mask);
  DOUBLES_EQUAL(1.5, p.bar_m, 5 * p.bar_sigma_m);
  CHECK(p.bar_sigma_m > 1e-5 && p.bar_sigma_m < 5e-3);
  CHECK(p.reprojection_px > 0.005 && p.reprojection_px < 0.04);
  for (std::size_t i = 0; i < 4; ++i) CHECK((p.leds_b_m[i] - bar.Point(bar.target.leds_m[i])).norm() < 0.01);
  DOUBLES_EQUAL(1, p.direction_b.norm(), 1e-12);
  CHECK((p.direction_covariance * p.direction_b).norm() < 1e-12);
  CHECK(chain.points.stamp.mid_exposure_ns == scene->Blobs().left.stamp.mid_exposure_ns);
  LONGS_EQUAL(1, chain.points.targets[1].target);
  LONGS_EQUAL(2, chain.points.targets.size());
}

TEST(Locator, DatesThePairByItsLaterPacket) {
  scene->Blobs().right.stamp.last_packet_ns = 1'009'000'000;
  chain.Run(scene->Blobs());
  CHECK(chain.points.stamp.last_packet_ns == 1'009'000'000);
  CHECK(chain.points.stamp.side == Side::kLeft);
}

TEST(Locator, FindsTwoTargetsAmongSixtyLamps) {
  const auto other =
      SyntheticBar::At(adit::support::SeedTargetTwo(), AheadM(55) + Vector3d(-1, 1, 0), {0, 1, 0.5});
  for (int trial = 0; trial < 200; ++trial) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.03));
    CHECK(scene->AddBar(other, 0.03));
    scene->AddLamps(60, 0.03);
    scene->Shuffle();
    chain.Run(scene->Blobs());
    CHECK(chain.points.targets[0].status == FixStatus::kTracked);
    CHECK(chain.points.targets[1].status == FixStatus::kTracked);
    CHECK(ErrorSigmas(chain.points.targets[0], bar) < 6);
    CHECK(ErrorSigmas(chain.points.targets[1], other) < 6);
  }
}

TEST(Locator, ReportsNothingAmongLampsAlone) {
  for (const int lamps : {60, 200}) {
    for (int trial = 0; trial < 40000 / lamps; ++trial) {
      scene->Clear();
      scene->AddLamps(lamps, 0.1);
      chain.Run(scene->Blobs());
      CHECK(chain.points.targets[0].status == FixStatus::kLost);
      CHECK(chain.points.targets[1].status == FixStatus::kLost);
    }
  }
}

TEST(Locator, ReportsNothingWhenTheRightImageHasOnlyLamps) {
  for (int trial = 0; trial < 300; ++trial) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.03));
    scene->Blobs().right.blobs.clear();
    scene->AddLamps(200, 0.03);
    chain.Run(scene->Blobs());
    CHECK(chain.points.targets[0].status == FixStatus::kLost);
  }
}

TEST(Locator, LosesATargetWithTwoLedsMissingOnTheRight) {
  CHECK(scene->AddBar(bar, 0.02));
  scene->Blobs().right.blobs.Truncate(2);
  CheckLost(LossReason::kNoCorrespondence, chain.Run(scene->Blobs()));
}

TEST(Locator, RefusesABarThatIsTooLong) {
  auto longer = bar;
  for (double& led_m : longer.target.leds_m) led_m *= 1.05;
  CHECK(scene->AddBar(longer, 0.02));
  CheckLost(LossReason::kDistances, chain.Run(scene->Blobs()));
}

TEST(Locator, RefusesTheMirroredLayout) {
  auto mirrored = bar;
  for (std::size_t i = 0; i < 4; ++i) mirrored.target.leds_m[i] = 1.5 - bar.target.leds_m[3 - i];
  CHECK(scene->AddBar(mirrored, 0.02));
  // It is the same bar, the other way round: that is what must be reported.
  const auto& p = chain.Run(scene->Blobs());
  CHECK(p.status == FixStatus::kTracked);
  CHECK(p.direction_b.dot(bar.direction_b) < -0.99);
}

TEST(Locator, RefusesLedsThatAreSwappedInOneImage) {
  // As if the right image showed the bar the other way round: each LED's counterpart on another epipolar
  // line.
  const auto turned = SyntheticBar::At(bar.target, AheadM(40), -bar.direction_b);
  CHECK(scene->AddBar(bar, 0.02));
  const auto left = scene->Blobs().left;
  scene->Clear();
  CHECK(scene->AddBar(turned, 0.02));
  scene->Blobs().left = left;
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
}

TEST(Locator, DoesNotFlipALayoutThatIsNearlyEven) {
  Chain even({{"even", {0, 0.49, 0.99, 1.5}, 2.0, 0.04}});
  int ambiguous = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    scene->Clear();
    const auto any = SyntheticBar::At(even.targets[0], AheadM(scene->Uniform(20, 100)), scene->Direction());
    if (!scene->AddBar(any, 0.03)) continue;
    const auto& p = even.Run(scene->Blobs());
    if (p.status == FixStatus::kTracked) CHECK(p.direction_b.dot(any.direction_b) > 0.9);
    if (p.reason == LossReason::kAmbiguous) ++ambiguous;
  }
  CHECK(ambiguous > 0);  // far away neither end can be told: then nothing is said
}

TEST(Locator, ReportsNeitherOfTwoEqualBars) {
  CHECK(scene->AddBar(bar, 0.02));
  CHECK(scene->AddBar(SyntheticBar::At(bar.target, AheadM(50) + Vector3d(-1, 1, 0), {0.3, 1, 0}), 0.02));
  CheckLost(LossReason::kAmbiguous, chain.Run(scene->Blobs()));
}

TEST(Locator, ReportsTheBarAndNotItsReflectionInWater) {
  // Water two metres below the camera; y points down.
  const auto above = SyntheticBar::At(bar.target, AheadM(40) + Vector3d(0, 1, 0), {1, 0.2, 0.3});
  const auto below = above.MirroredAt(2);
  CHECK(scene->AddBar(above, 0.02));
  CHECK(scene->AddBar(below, 0.02));
  for (std::size_t i = 4; i < 8; ++i) scene->Blobs().left.blobs[i].flux_dn *= 0.4F;
  scene->Shuffle();
  const auto& p = chain.Run(scene->Blobs());
  CHECK(p.status == FixStatus::kTracked);
  CHECK(ErrorSigmas(p, above) < 6);
}

TEST(Locator, ReportsNeitherOfTwoTargetsThatClaimTheSameBlobs) {
  auto twin = adit::support::SeedTargetOne();
  twin.name = "twin", twin.epicenter_m = 3;
  Chain both({adit::support::SeedTargetOne(), twin});
  CHECK(scene->AddBar(bar, 0.02));
  both.Run(scene->Blobs());
  CheckLost(LossReason::kAmbiguous, both.points.targets[0]);
  CheckLost(LossReason::kAmbiguous, both.points.targets[1]);
}

TEST(Locator, GivesSharedBlobsToTheTargetThatFitsClearlyBetter) {
  auto longer = adit::support::SeedTargetOne();
  longer.name = "longer";
  for (double& led_m : longer.leds_m) led_m *= 1.012;
  Chain both({adit::support::SeedTargetOne(), longer});
  CHECK(scene->AddBar(SyntheticBar::At(bar.target, AheadM(25), {1, 0.2, 0.3}), 0.02));
  both.Run(scene->Blobs());
  CHECK(both.points.targets[0].status == FixStatus::kTracked);
  CHECK(both.points.targets[1].status == FixStatus::kLost);
}

TEST(Locator, ToleratesARigThatHasTurnedALittleButNotMuch) {
  CHECK(scene->AddBar(bar, 0.02));
  for (auto& blob : scene->Blobs().right.blobs) blob.ideal_px.y() += 0.7;
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
  for (auto& blob : scene->Blobs().right.blobs) blob.ideal_px.y() += 1.3;
  CheckLost(LossReason::kNoCorrespondence, chain.Run(scene->Blobs()));
}

TEST(Locator, LosesEveryTargetWhenAFrameIsUnusable) {
  CHECK(scene->AddBar(bar, 0.02));
  scene->Blobs().right.stamp.status = adit::base::FrameStatus::kIncomplete;
  chain.Run(scene->Blobs());
  CheckLost(LossReason::kNoFrame, chain.points.targets[0]);
  CheckLost(LossReason::kNoFrame, chain.points.targets[1]);
}

TEST(Locator, DatesAPairWithoutALeftFrameByItsRightOne) {
  scene->Blobs().left.stamp = {};
  scene->Blobs().left.stamp.status = adit::base::FrameStatus::kIncomplete;
  chain.Run(scene->Blobs());
  CHECK(chain.points.stamp.mid_exposure_ns == scene->Blobs().right.stamp.mid_exposure_ns);
}

TEST(Locator, ConcludesNothingFromARightImageCrowdedAlongTheLines) {
  CHECK(scene->AddBar(bar, 0.02));
  const Vector2d led = scene->Blobs().right.blobs[0].raw_px;
  for (int i = 0; i < 60; ++i) scene->AddBlob(Side::kRight, led + Vector2d(4 + 3 * i, 0), 0.02);
  CHECK(chain.Run(scene->Blobs()).status != FixStatus::kTracked);
}

TEST(Locator, PassesOverRightBlobsThatAreNoNumbers) {
  CHECK(scene->AddBar(bar, 0.02));
  scene->AddLamps(4, 0.02);
  auto& blobs = scene->Blobs().right.blobs;
  blobs[4].ideal_px.x() = std::nan("");
  blobs[5].covariance_px2(0, 0) = std::nan("");
  blobs[6].ideal_px.y() = HUGE_VAL;
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
}

TEST(Locator, AllocatesNothing) {
  if (!adit::support::CountsAllocations()) return;
  CHECK(scene->AddBar(bar, 0.02));
  scene->AddLamps(200, 0.02);
  const auto before = adit::support::AllocationCount();
  chain.Run(scene->Blobs());
  LONGS_EQUAL(before, adit::support::AllocationCount());
  CHECK(chain.points.targets[0].status == FixStatus::kTracked);
}
