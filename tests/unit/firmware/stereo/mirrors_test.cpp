#include "tests/unit/firmware/stereo/chain.h"
#include "tests/unit/firmware/stereo/hiding.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::stereo::TargetPoints;
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

TEST_GROUP(Mirrors) {
  Chain chain{{adit::support::SeedTargetOne(), adit::support::ShortTarget()}};
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(chain.rig, 11);
  // Water two metres below the camera; y points down.
  SyntheticBar above =
      SyntheticBar::At(adit::support::SeedTargetOne(), AheadM(40) + Vector3d(0, 1, 0), {1, 0.2, 0.3});
  SyntheticBar below = above.MirroredAt(2);

  /// Of the bar that was added second.
  void DimReflection() const {
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) {
      for (std::size_t i = 4; i < 8; ++i) set->blobs[i].flux_dn *= 0.4F;
    }
  }
};

TEST(Mirrors, ReportsABarOfThreeLedsAndNotItsWholeReflectionInWater) {
  for (const unsigned images : {kLeft, kRight, kBoth}) {
    for (std::size_t led = 0; led < 8; ++led) {
      scene->Clear();
      CHECK(scene->AddBar(above, 0.02));
      CHECK(scene->AddBar(below, 0.02));
      DimReflection();
      Hide(scene->Blobs(), led, images);
      const TargetPoints& p = chain.Run(scene->Blobs());
      CHECK(p.status == (led < 4 ? FixStatus::kRecovered : FixStatus::kTracked));
      CHECK(ErrorSigmas(p, above) < 6);
    }
  }
}

TEST(Mirrors, WhatStandsBehindAKnownMirrorIsNoTarget) {
  CHECK(scene->AddBar(above, 0.02));
  CHECK(scene->AddBar(below, 0.02));
  DimReflection();
  CHECK(ErrorSigmas(chain.Run(scene->Blobs()), above) < 6);
  // The bar is hidden, its reflection is not; and nobody follows it.
  scene->Clear();
  CHECK(scene->AddBar(below, 0.02));
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
  // Elsewhere above the water it is found.
  scene->Clear();
  auto beside = above;
  beside.led1_b_m.x() -= 1;
  CHECK(scene->AddBar(beside, 0.02));
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
}

TEST(Mirrors, TheReflectionOfAFollowedBarIsNotTheBarWhileItIsHidden) {
  CHECK(scene->AddBar(below, 0.02));
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
  chain.expectations[0] = Expect(above, 0.02);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
}

TEST(Mirrors, AReflectionOfABarThatShowsTwoLedsIsNoTarget) {
  for (std::size_t led = 0; led < 4; ++led) {
    for (std::size_t other = led + 1; other < 4; ++other) {
      for (const bool whole : {true, false}) {
        scene->Clear();
        CHECK(scene->AddBar(above, 0.02));
        CHECK(scene->AddBar(below, 0.02));
        DimReflection();
        if (!whole) Hide(scene->Blobs(), 6, kBoth);
        Hide(scene->Blobs(), other, kBoth);
        Hide(scene->Blobs(), led, kBoth);
        CHECK(chain.Run(scene->Blobs()).reason == LossReason::kAmbiguous);
      }
    }
  }
}

TEST(Mirrors, LightsThatAreNotAlikeOrDimmerThanABarAreNotReflectedByIt) {
  for (const auto& [first, second] : {std::pair{0.3F, 0.3F}, std::pair{1.0F, 1.4F}}) {
    scene->Clear();
    CHECK(scene->AddBar(above, 0.02));
    CHECK(scene->AddBar(below, 0.02));
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right})
      set->blobs[0].flux_dn *= first, set->blobs[3].flux_dn *= second;
    Hide(scene->Blobs(), 2, kBoth);
    Hide(scene->Blobs(), 1, kBoth);
    CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
    CHECK(ErrorSigmas(chain.points.targets[0], below) < 6);
  }
}

TEST(Mirrors, ABarIsNoReflectionOfLightsBehindItsMirror) {
  // Two LEDs of the reflection of a bar are seen below it: the bar itself is on the cameras' side.
  CHECK(scene->AddBar(above, 0.02));
  CHECK(scene->AddBar(below, 0.02));
  Hide(scene->Blobs(), 6, kBoth);
  Hide(scene->Blobs(), 5, kBoth);
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kTracked);
  CHECK(ErrorSigmas(chain.points.targets[0], above) < 6);
}

TEST(Mirrors, TheReflectionOfABarSeenAMomentAgoIsNotTheBar) {
  CHECK(scene->AddBar(below, 0.02));
  Hide(scene->Blobs(), 1, kBoth);
  chain.expectations[0] = Expect(above, 0.1);
  chain.expectations[0].known = false;
  chain.expectations[0].recent = true;
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
  // Where it was it is found.
  chain.expectations[0] = Expect(below, 0.1);
  chain.expectations[0].known = false;
  chain.expectations[0].recent = true;
  CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
}
