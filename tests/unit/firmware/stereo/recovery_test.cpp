#include <algorithm>
#include <cmath>

#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/stereo/chain.h"
#include "tests/unit/firmware/stereo/hiding.h"

#include <CppUTest/TestHarness.h>

using adit::base::Side;
using adit::stereo::FixStatus;
using adit::stereo::kNoBlob;
using adit::stereo::LossReason;
using adit::stereo::TargetPoints;
using adit::stereo_tests::AddLightInLine;
using adit::stereo_tests::Chain;
using adit::stereo_tests::ErrorSigmas;
using adit::stereo_tests::Expect;
using adit::stereo_tests::Hide;
using adit::stereo_tests::kBoth;
using adit::stereo_tests::kLeft;
using adit::stereo_tests::kRight;
using adit::support::AheadM;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;
using Eigen::Vector3d;

TEST_GROUP(Recovery) {
  // Layouts of which no three LEDs are alike: those of the seed share LEDs 1, 2 and 4.
  Chain chain{{adit::support::SeedTargetOne(), adit::support::ShortTarget()}};
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(chain.rig, 11);
  SyntheticBar bar = SyntheticBar::At(adit::support::SeedTargetOne(), AheadM(40), {1, 0.2, 0.3});
};

TEST(Recovery, FindsABarWithAnyOneLedHiddenInOneImageOrInBoth) {
  for (const unsigned images : {kLeft, kRight, kBoth}) {
    for (std::size_t led = 0; led < 4; ++led) {
      scene->Clear();
      CHECK(scene->AddBar(bar, 0.02));
      Hide(scene->Blobs(), led, images);
      const TargetPoints& p = chain.Run(scene->Blobs());
      CHECK(p.status == FixStatus::kRecovered);
      LONGS_EQUAL(1U << led, p.recovered_mask);
      CHECK(ErrorSigmas(p, bar) < 5);
      CHECK(p.direction_b.dot(bar.direction_b) > 0.999);
      for (std::size_t i = 0; i < 4; ++i)
        CHECK((p.leds_b_m[i] - bar.Point(bar.target.leds_m[i])).norm() < 0.02);
      CHECK((p.blobs[0][led] == kNoBlob) == ((images & kLeft) != 0));
      CHECK((p.blobs[1][led] == kNoBlob) == ((images & kRight) != 0));
      CHECK(chain.points.targets[1].status == FixStatus::kLost);
    }
  }
}

TEST(Recovery, AnLedSeenInOneImageStillHelps) {
  CHECK(scene->AddBar(bar, 0.02));
  const double whole = chain.Run(scene->Blobs()).epicenter_covariance_m2.trace();
  auto blobs = scene->Blobs();
  Hide(blobs, 0, kRight);
  const double with_ray = chain.Run(blobs).epicenter_covariance_m2.trace();
  Hide(blobs, 0, kLeft);
  const double without = chain.Run(blobs).epicenter_covariance_m2.trace();
  CHECK(whole < with_ray);
  CHECK(with_ray < without);
}

TEST(Recovery, FindsThreeLedsAmongSixtyLampsAndNothingWrong) {
  int shown = 0, found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    scene->Clear();
    const std::size_t which = static_cast<std::size_t>(trial % 2);
    const auto any =
        SyntheticBar::At(chain.targets[which], AheadM(scene->Uniform(20, 80)), scene->Direction());
    if (!scene->AddBar(any, 0.03)) continue;
    Hide(scene->Blobs(), static_cast<std::size_t>(scene->Uniform(0, 4)),
         static_cast<unsigned>(scene->Uniform(1, 4)));
    scene->AddLamps(60, 0.03);
    scene->Shuffle();
    chain.Run(scene->Blobs());
    ++shown;
    CHECK(chain.points.targets[1 - which].status == FixStatus::kLost);
    const TargetPoints& p = chain.points.targets[which];
    if (p.status == FixStatus::kLost) continue;
    ++found;
    CHECK(p.direction_b.dot(any.direction_b) > 0.99);
    CHECK(ErrorSigmas(p, any) < 6);
  }
  CHECK(shown > 100);
  CHECK(found >= 0.97 * shown);
}

TEST(Recovery, SaysNothingWhenThreeLedsFitTwoTargets) {
  // Seen without LED 3 the seed's bars are the same.
  Chain both({adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()});
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 2, kBoth);
  both.Run(scene->Blobs());
  CHECK(both.points.targets[0].reason == LossReason::kAmbiguous);
  CHECK(both.points.targets[1].reason == LossReason::kAmbiguous);
}

TEST(Recovery, AnLedCoveredInPartInTheOtherImageIsNotTaken) {
  for (const auto& [images, side] : {std::pair{kLeft, 1U}, std::pair{kRight, 0U}}) {
    for (const float shown : {0.97F, 0.85F}) {
      scene->Clear();
      CHECK(scene->AddBar(bar, 0.02));
      (side == 0 ? scene->Blobs().left : scene->Blobs().right).blobs[1].flux_dn *= shown;
      Hide(scene->Blobs(), 1, images);
      const TargetPoints& p = chain.Run(scene->Blobs());
      CHECK(p.status == FixStatus::kRecovered);
      CHECK((p.blobs[side][1] != kNoBlob) == (shown > 0.9F));
    }
  }
}

TEST(Recovery, AFollowedBarIsNotSeenInThreeLightsElsewhere) {
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 1, kBoth);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
  chain.expectations[0] = Expect(SyntheticBar::At(bar.target, AheadM(49), bar.direction_b), 0.1);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
}

TEST(Recovery, ALampThatMergedWithAnLedCountsAsHidingIt) {
  for (std::size_t led = 0; led < 4; ++led) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    // The common centroid of both is off by more than its covariance says.
    scene->Blobs().left.blobs[led].ideal_px += Eigen::Vector2d(1.5, 2);
    const TargetPoints& p = chain.Run(scene->Blobs());
    CHECK(p.status == FixStatus::kRecovered);
    LONGS_EQUAL(1U << led, p.recovered_mask);
    CHECK(ErrorSigmas(p, bar) < 5);
  }
}

TEST(Recovery, AFollowedBarIsFoundWithAnyTwoLeds) {
  chain.expectations[0] = Expect(bar, 0.03);
  for (std::size_t first = 0; first < 4; ++first) {
    for (std::size_t second = 0; second < first; ++second) {
      for (const unsigned images : {kLeft, kRight, kBoth}) {
        scene->Clear();
        CHECK(scene->AddBar(bar, 0.02));
        Hide(scene->Blobs(), first, images);
        Hide(scene->Blobs(), second, images);
        scene->AddLamps(60, 0.02);
        const TargetPoints& p = chain.Run(scene->Blobs());
        CHECK(p.status == FixStatus::kRecovered);
        LONGS_EQUAL(1U << first | 1U << second, p.recovered_mask);
        CHECK(ErrorSigmas(p, bar) < 5);
      }
    }
  }
}

TEST(Recovery, TwoLedsAreNoTargetUnlessItIsFollowed) {
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 2, kBoth);
  Hide(scene->Blobs(), 0, kBoth);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
  chain.expectations[0] = Expect(SyntheticBar::At(bar.target, AheadM(50), bar.direction_b), 0.03);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
}

TEST(Recovery, TheExpectationDoesNotMoveThePlace) {
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 1, kBoth);
  const Vector3d free_m = chain.Run(scene->Blobs()).epicenter_b_m;
  auto beside = bar;
  beside.led1_b_m += Vector3d(0.03, -0.02, 0.03);
  chain.expectations[0] = Expect(beside, 0.03);
  const TargetPoints& p = chain.Run(scene->Blobs());
  CHECK(p.status == FixStatus::kRecovered);
  CHECK((p.epicenter_b_m - free_m).norm() < 1e-9);
}

TEST(Recovery, AFollowedBarIsFoundInARowOfLampsWithThreeLeds) {
  int found = 0;
  for (int trial = 0; trial < 100; ++trial) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    Hide(scene->Blobs(), static_cast<std::size_t>(trial % 4), kBoth);
    for (int i = 0; i < 20; ++i) {
      const double place_m = -1.95 + 0.2 * i + scene->Uniform(-0.05, 0.05);
      // Who stands in an LED's place is taken for it.
      constexpr double kInItsPlaceM = 0.03;
      const auto is_led = [place_m](double led_m) { return std::abs(place_m - led_m) < kInItsPlaceM; };
      if (std::any_of(bar.target.leds_m.begin(), bar.target.leds_m.end(), is_led)) continue;
      AddLightInLine(*scene, bar, place_m);
    }
    scene->Shuffle();
    chain.expectations[0] = Expect(bar, 0.01);
    const TargetPoints& p = chain.Run(scene->Blobs());
    if (p.status == FixStatus::kLost) continue;
    ++found;
    CHECK(ErrorSigmas(p, bar) < 6);
  }
  CHECK(found >= 98);
}

TEST(Recovery, AnLedBrighterThanItWasCountsAsHidden) {
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 3, kBoth);
  chain.expectations[0] = Expect(bar, 0.03);
  for (auto& side : chain.expectations[0].flux_dn) side.fill(scene->Blobs().left.blobs[0].flux_dn);
  LONGS_EQUAL(1U << 3, chain.Run(scene->Blobs()).recovered_mask);
  for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) set->blobs[0].flux_dn *= 1.5F;
  const TargetPoints& p = chain.Run(scene->Blobs());
  CHECK(p.status == FixStatus::kRecovered);
  LONGS_EQUAL(1U << 3 | 1U, p.recovered_mask);
}

TEST(Recovery, StatesItsUncertaintyHonestlyWithThreeLedsAndWithTwo) {
  constexpr int kTrials = 400;
  for (const double distance_m : {20.0, 50.0, 100.0}) {
    for (const bool followed : {false, true}) {
      int inside = 0, count = 0;
      double nees = 0;
      while (count < kTrials) {
        scene->Clear();
        const auto any = SyntheticBar::At(bar.target, AheadM(distance_m), scene->Direction());
        if (std::abs(any.direction_b.z()) > 0.8 || !scene->AddBar(any, 0.02)) continue;
        chain.expectations[0] = {};
        const auto led = static_cast<std::size_t>(scene->Uniform(0, 4));
        Hide(scene->Blobs(), led, kBoth);
        if (followed) {
          Hide(scene->Blobs(), static_cast<std::size_t>(scene->Uniform(0, 3)), kBoth);
          chain.expectations[0] = Expect(any, 0.2);
        }
        const TargetPoints& p = chain.Run(scene->Blobs());
        if (p.status != FixStatus::kRecovered) continue;
        const double sigmas = ErrorSigmas(p, any);
        constexpr double kInside95 = 7.815;  // chi-square, 3 degrees of freedom
        inside += sigmas * sigmas < kInside95 ? 1 : 0;
        nees += sigmas * sigmas / kTrials;
        ++count;
      }
      // Four standard deviations of a share of 0.95.
      DOUBLES_EQUAL(0.95, static_cast<double>(inside) / kTrials, 4 * std::sqrt(0.95 * 0.05 / kTrials));
      DOUBLES_EQUAL(3, nees, 4 * std::sqrt(6.0 / kTrials));
    }
  }
}

TEST(Recovery, AllocatesNothing) {
  if (!adit::support::CountsAllocations()) return;
  CHECK(scene->AddBar(bar, 0.02));
  Hide(scene->Blobs(), 1, kBoth);
  scene->AddLamps(100, 0.02);
  const auto before = adit::support::AllocationCount();
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
  chain.expectations[0] = Expect(bar, 0.03);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
  LONGS_EQUAL(before, adit::support::AllocationCount());
}
