#include "tests/unit/firmware/stereo/chain.h"
#include "tests/unit/firmware/stereo/hiding.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::FixStatus;
using adit::stereo::LossReason;
using adit::stereo::TargetPoints;
using adit::stereo_tests::AddLightInLine;
using adit::stereo_tests::Chain;
using adit::stereo_tests::ErrorSigmas;
using adit::stereo_tests::Hide;
using adit::stereo_tests::kBoth;
using adit::stereo_tests::kLeft;
using adit::stereo_tests::kRight;
using adit::stereo_tests::Obscure;
using adit::support::AheadM;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;

TEST_GROUP(TripleBars) {
  // Layouts of which no three LEDs are alike: those of the seed share LEDs 1, 2 and 4.
  Chain chain{{adit::support::SeedTargetOne(), adit::support::ShortTarget()}};
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(chain.rig, 11);
  SyntheticBar bar = SyntheticBar::At(adit::support::SeedTargetOne(), AheadM(40), {1, 0.2, 0.3});
};

TEST(TripleBars, DoesNotBelieveThreeLightsInARowOfLamps) {
  // Lamps every 13 cm along the bar's own line, in both images, from an irregular start: some three of them
  // stand as three LEDs do.
  int reported = 0;
  for (int trial = 0; trial < 100; ++trial) {
    scene->Clear();
    for (int i = 0; i < 24; ++i) {
      AddLightInLine(*scene, bar, -0.8 + 0.13 * i + scene->Uniform(-0.03, 0.03));
    }
    scene->Shuffle();
    chain.Run(scene->Blobs());
    for (const TargetPoints& p : chain.points.targets) reported += p.status == FixStatus::kRecovered ? 1 : 0;
  }
  LONGS_EQUAL(0, reported);
}

TEST(TripleBars, BesideAnotherLightTheFourthLedMustBeSeenOrHiddenByALight) {
  for (std::size_t led = 0; led < 4; ++led) {
    const auto put = [&] {
      scene->Clear();
      CHECK(scene->AddBar(bar, 0.02));
      AddLightInLine(*scene, bar, 2.1);
    };
    put();
    Hide(scene->Blobs(), led, kBoth);
    CHECK(chain.Run(scene->Blobs()).reason == LossReason::kAmbiguous);
    // A region in one image hides the LED there and not in the other.
    put();
    Obscure(scene->Blobs().left, led);
    Hide(scene->Blobs(), led, kBoth);
    CHECK(chain.Run(scene->Blobs()).status == FixStatus::kLost);
    put();
    Obscure(scene->Blobs().left, led);
    Obscure(scene->Blobs().right, led);
    Hide(scene->Blobs(), led, kBoth);
    CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
    CHECK(ErrorSigmas(chain.points.targets[0], bar) < 5);
    for (const unsigned images : {kLeft, kRight}) {
      put();
      Hide(scene->Blobs(), led, images);
      CHECK(chain.Run(scene->Blobs()).status == FixStatus::kRecovered);
    }
  }
}

TEST(TripleBars, ThreeLightsThatAreNotAlikeAreNoBar) {
  for (const float brighter : {1.1F, 1.4F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    Hide(scene->Blobs(), 2, kBoth);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) set->blobs[1].flux_dn *= brighter;
    CHECK((chain.Run(scene->Blobs()).status == FixStatus::kRecovered) == (brighter < 1.2F));
  }
}

TEST(TripleBars, ThreeLampsOfAnEvenRowAreNoBar) {
  // LEDs 1, 2 and 4 stand at one step and at two: with a lamp in between they are four of a row.
  const adit::base::Target even{"even", {0, 0.50, 1.25, 1.50}, 0.75, 0.04};
  Chain others({even});
  bar.target = even;
  struct Case {
    double place_m;
    float brighter;
    bool is_row;
  };
  for (const Case& c : {Case{1, 1, true}, Case{2.02, 1.2F, true}, Case{-0.98, 1, true}, Case{1.1, 1, false},
                        Case{1, 2, false}, Case{1.2, 1, false}}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    AddLightInLine(*scene, bar, c.place_m);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) {
      Obscure(*set, 2);
      set->blobs[4].flux_dn *= c.brighter;
    }
    Hide(scene->Blobs(), 2, kBoth);
    const TargetPoints& p = others.Run(scene->Blobs());
    CHECK((p.status == FixStatus::kLost) == c.is_row);
    CHECK(c.is_row || ErrorSigmas(p, bar) < 5);
  }
}

TEST(TripleBars, AnLedThatMergedWithALampIsBrighterThanARowsLamp) {
  const adit::base::Target even{"even", {0, 0.50, 1.25, 1.50}, 0.75, 0.04};
  Chain others({even});
  bar.target = even;
  for (const float brighter : {1.0F, 2.0F}) {
    scene->Clear();
    CHECK(scene->AddBar(bar, 0.02));
    AddLightInLine(*scene, bar, 1);
    AddLightInLine(*scene, bar, 1.256);
    for (auto* set : {&scene->Blobs().left, &scene->Blobs().right}) {
      set->blobs[5].flux_dn *= brighter;
      Obscure(*set, 2);
    }
    Hide(scene->Blobs(), 2, kBoth);
    CHECK((others.Run(scene->Blobs()).status == FixStatus::kRecovered) == (brighter > 1));
  }
}
