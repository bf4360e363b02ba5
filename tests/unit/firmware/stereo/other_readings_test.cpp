#include "tests/unit/firmware/stereo/chain.h"
#include "tests/unit/firmware/stereo/hiding.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::FixStatus;
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
using adit::stereo_tests::Obscure;
using adit::support::AheadM;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;

namespace {

const adit::base::Target kOne{"one", {0, 0.50, 1.25, 1.50}, 0.75, 0.04};
const adit::base::Target kTwo{"two", {0, 0.25, 0.62, 0.83}, 0.40, 0.04};

}  // namespace

/// LEDs 1 and 2 of `one`, read backwards, are its LEDs 2 and 1: then LED 3 is at -0.75 m, LED 4 at -1 m.
TEST_GROUP(OtherReadings) {
  Chain chain{{kOne}};
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(chain.rig, 12);
  SyntheticBar bar = SyntheticBar::At(kOne, AheadM(40), {1, 0.2, 0.3});

  void AddLight(double place_m, float brightness) {
    AddLightInLine(*scene, bar, place_m);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right})
      set->blobs[set->blobs.size() - 1].flux_dn *= brightness;
  }
  /// Lets LED 1 to 4, or a light beyond these, merge with a lamp that is no blob itself.
  void Merge(std::size_t index, unsigned images) {
    if ((images & kLeft) != 0) Obscure(scene->Blobs().left, index);
    if ((images & kRight) != 0) Obscure(scene->Blobs().right, index);
    Hide(scene->Blobs(), index, images);
  }
};

TEST(OtherReadings, TwoLedsBackwardsAndALampAreNotBelievedWhereTheOtherLedsAreSeenToo) {
  scene->Clear();
  CHECK(scene->AddBar(bar, 0.02));
  AddLight(-1, 1);
  AddLight(-0.75, 1);
  Merge(5, kBoth);
  Merge(3, kRight);
  Merge(2, kRight);
  CHECK(chain.Run(scene->Blobs()).reason == LossReason::kAmbiguous);
}

TEST(OtherReadings, WhatWasReadInTwoWaysAMomentAgoIsNotBelievedWhenLedsOfOneAreHidden) {
  const auto look = [&](double at_s, bool lamps) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    if (lamps) {
      AddLight(-0.75, 1);
      AddLight(-1, 1);
      Merge(5, kBoth);
    }
    Merge(3, kBoth);
    const auto at_ns = static_cast<adit::base::TimeNs>(at_s * adit::base::kNsPerS);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) set->stamp.mid_exposure_ns = at_ns;
    return chain.Run(scene->Blobs()).status;
  };
  CHECK(look(0, false) == FixStatus::kRecovered);
  CHECK(look(0.1, true) == FixStatus::kLost);
  CHECK(look(0.9, false) == FixStatus::kLost);
  CHECK(look(1.8, false) == FixStatus::kLost);
  CHECK(look(3, false) == FixStatus::kRecovered);
}

TEST(OtherReadings, LedsThatMergedWithLampsCountLikeThoseThatAreSeen) {
  scene->Clear();
  CHECK(scene->AddBar(bar, 0.02));
  AddLight(-0.75, 1);
  AddLight(-1, 1);
  Merge(5, kBoth);
  Merge(3, kBoth);
  Merge(2, kBoth);
  CHECK(chain.Run(scene->Blobs()).reason == LossReason::kAmbiguous);
}

TEST(OtherReadings, OnlyWhatIsBrighterHidesAnLed) {
  for (const float brightness : {0.4F, 2.0F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    AddLight(2.1, 1);
    AddLight(1.53, brightness);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) {
      adit::detect::Blob& light = set->blobs[set->blobs.size() - 1];
      const auto x_px = static_cast<std::uint16_t>(light.raw_px.x());
      const auto y_px = static_cast<std::uint16_t>(light.raw_px.y());
      light.x_min_px = x_px - 3, light.x_max_px = x_px + 3, light.y_min_px = y_px - 3,
      light.y_max_px = y_px + 3;
    }
    Hide(scene->Blobs(), 3, kBoth);
    CHECK((chain.Run(scene->Blobs()).status == FixStatus::kRecovered) == (brightness > 1));
  }
}

TEST(OtherReadings, TwoLedsMustBeAsBrightAsTheyWere) {
  chain.expectations[0] = Expect(bar, 0.02);
  for (const float brighter : {1.05F, 1.2F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    scene->Blobs().left.blobs[0].flux_dn *= brighter;
    Hide(scene->Blobs(), 2, kBoth);
    Hide(scene->Blobs(), 1, kBoth);
    CHECK((chain.Run(scene->Blobs()).status == FixStatus::kRecovered) == (brighter < 1.1F));
  }
}

TEST(OtherReadings, FourLightsOfWhichThreeMayBeReadOtherwiseMustBeAlike) {
  for (const float brightness : {1.0F, 0.75F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    AddLight(-0.75, 1.1F);
    AddLight(-1, brightness);
    Merge(3, kBoth);
    const TargetPoints& p = chain.Run(scene->Blobs());
    // Four lights alike, where four LEDs would be, nothing tells from the LEDs.
    CHECK((p.status == FixStatus::kLost) == (brightness < 1));
  }
}

TEST(OtherReadings, ADimLedIsOneOfFourUpToHalfAndHiddenBeyond) {
  for (const float dimmer : {1.4F, 1.7F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) set->blobs[3].flux_dn /= dimmer;
    const TargetPoints& p = chain.Run(scene->Blobs());
    CHECK(p.status == (dimmer < 1.5F ? FixStatus::kTracked : FixStatus::kRecovered));
    CHECK(ErrorSigmas(p, bar) < 5);
  }
}

TEST(OtherReadings, ATargetThatIsFollowedComesBackElsewhereOnlyWithLedsAlike) {
  const SyntheticBar before = SyntheticBar::At(kOne, AheadM(43), {1, 0.2, 0.3});
  for (const bool followed : {false, true}) {
    for (const float dimmer : {1.1F, 1.4F}) {
      scene->Clear();
      CHECK(scene->AddBar(bar, 0.02));
      for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) set->blobs[3].flux_dn /= dimmer;
      chain.expectations[0] = Expect(before, 0.02);
      chain.expectations[0].known = followed;
      CHECK((chain.Run(scene->Blobs()).status == FixStatus::kTracked) == (!followed || dimmer < 1.2F));
    }
  }
}

TEST(OtherReadings, ALightThatOneCameraSeesBrighterIsNotOneLight) {
  chain.expectations[0] = Expect(bar, 0.02);
  for (const float brighter : {1.2F, 2.5F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    scene->Blobs().left.blobs[3].flux_dn *= brighter;
    const TargetPoints& p = chain.Run(scene->Blobs());
    CHECK(p.status == (brighter < 1.5F ? FixStatus::kTracked : FixStatus::kRecovered));
    CHECK(ErrorSigmas(p, bar) < 5);
  }
}

TEST(OtherReadings, LedsOfATargetThatIsFollowedAreNoOthers) {
  // LEDs 3 and 4 of one stand as LEDs 1 and 2 of two, and a lamp as its LED 4. Among many lamps LEDs 3 and 4
  // alone are not enough for one.
  Chain both{{kOne, kTwo}};
  for (const bool followed : {false, true}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    AddLight(2.08, 1);
    Hide(scene->Blobs(), 1, kBoth);
    Hide(scene->Blobs(), 0, kBoth);
    scene->AddLamps(200, 0.02);
    both.expectations[0] = Expect(bar, 0.1);
    both.expectations[0].known = followed;
    both.Run(scene->Blobs());
    CHECK(both.points.targets[0].status == FixStatus::kLost);
    CHECK((both.points.targets[1].status == FixStatus::kLost) == followed);
  }
}
