// Searching in windows changes what a pair costs, never a position: and what enters or comes back is found
// two pairs later at most.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "firmware/pipeline/pipeline.h"
#include "tests/support/rendered_spots.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::CameraFrame;
using adit::base::Side;
using adit::pipeline::Pipeline;
using adit::stereo::FixStatus;
using adit::support::RenderedImage;
using adit::support::SyntheticBar;
using adit::support::SyntheticCamera;

/// The pipeline with windows or without, and the records of its last pair.
struct Line {
  adit::base::Result<Pipeline> pipeline;
  std::unique_ptr<adit::detect::BlobSet> left = std::make_unique<adit::detect::BlobSet>(),
                                         right = std::make_unique<adit::detect::BlobSet>();
  std::unique_ptr<adit::pipeline::PairResult> result = std::make_unique<adit::pipeline::PairResult>();

  Line(const adit::optics::Rig& rig, const std::vector<adit::identify::Model>& models, bool windows)
      : pipeline(Pipeline::Make(rig, models, {.detector = {}, .windows = windows})) {}

  void Take(const CameraFrame& left_frame, const CameraFrame& right_frame) {
    pipeline->Detect(left_frame, *left);
    pipeline->Detect(right_frame, *right);
    pipeline->Locate(*left, *right, *result);
  }
  FixStatus StatusOf(std::size_t target) const { return result->points.targets[target].status; }
  bool Whole() const { return left->whole && right->whole; }
};

}  // namespace

TEST_GROUP(SearchInWindows) {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  std::vector<adit::base::Target> targets{adit::support::SeedTargetOne(), adit::support::SeedTargetTwo()};
  std::vector<adit::identify::Model> models{adit::support::ModelOf(targets[0], 20),
                                            adit::support::ModelOf(targets[1], 20)};
  Line with{rig.AsRig(), models, true}, without{rig.AsRig(), models, false};
  int pair = 0;
  std::array<int, 2> pairs_late{};
  std::optional<std::size_t> hidden_led;  ///< of the second target
  int longest_late = 0;                   ///< pairs in a row in which only the whole search saw a target

  RenderedImage Render(const SyntheticCamera& camera, const std::vector<SyntheticBar>& bars) {
    RenderedImage image(camera.width_px, camera.height_px);
    image.Background(8);
    for (const SyntheticBar& bar : bars) {
      for (std::size_t i = 0; i < adit::base::kLedCount; ++i) {
        if (bar.target.name == targets[1].name && hidden_led == i) continue;
        const Eigen::Vector2d at_px = camera.Distorted(*camera.ProjectIdeal(bar.Point(bar.target.leds_m[i])));
        image.Add({at_px.x(), at_px.y(), 1.6, 180});
      }
    }
    for (int i = 0; i < 30; ++i) image.Add({30.3 + 44 * i, 40.2 + 31 * ((i * 7) % 30), 2.2, 160});
    image.Expose({}, nullptr);
    return image;
  }
  /// One more pair of both lines, of the targets that `shown` names. They move 8 m/s aside and turn.
  void Next(const std::vector<std::size_t>& shown) {
    std::vector<SyntheticBar> bars;
    for (const std::size_t t : shown) {
      const double s = pair / 60.0;
      const Eigen::Vector3d aside(t == 0 ? -1.2 + 2 * s : 1.0 - 1.5 * s, t == 0 ? -0.8 : 0.7, 0);
      bars.push_back(SyntheticBar::At(targets[t], Ahead(rig, 40 - 5 * s) + aside,
                                      Eigen::Vector3d(0.9, 0.3 + 0.6 * s, 0.2)));
    }
    const RenderedImage left_image = Render(rig.left, bars), right_image = Render(rig.right, bars);
    CameraFrame left = left_image.Frame(), right = right_image.Frame();
    right.stamp.side = Side::kRight;
    left.stamp.mid_exposure_ns = right.stamp.mid_exposure_ns = 1 + pair++ * 16'666'667LL;
    with.Take(left, right);
    without.Take(left, right);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const bool late = without.StatusOf(t) == FixStatus::kTracked && with.StatusOf(t) != FixStatus::kTracked;
      pairs_late[t] = late ? pairs_late[t] + 1 : 0;
      longest_late = std::max(longest_late, pairs_late[t]);
    }
    CheckSamePositions();
  }
  void CheckSamePositions() const {
    for (std::size_t t = 0; t < targets.size(); ++t) {
      if (with.StatusOf(t) == FixStatus::kLost) continue;
      const auto &a = with.result->points.targets[t], &b = without.result->points.targets[t];
      CHECK(b.status == a.status);
      CHECK(a.epicenter_b_m == b.epicenter_b_m);  // bit for bit
      CHECK(a.epicenter_covariance_m2 == b.epicenter_covariance_m2);
    }
  }
};

TEST(SearchInWindows, PositionsAreBitForBitThoseOfTheWholeSearch) {
  int whole = 0;
  constexpr int kPairs = 33;
  for (int i = 0; i < kPairs; ++i) {
    Next({0, 1});
    CHECK(FixStatus::kTracked == with.StatusOf(0) && FixStatus::kTracked == with.StatusOf(1));
    CHECK(without.Whole());
    whole += with.Whole() ? 1 : 0;
    if (!with.Whole()) CHECK(with.left->blobs.size() < without.left->blobs.size());
  }
  // The first two, then every fifteenth.
  LONGS_EQUAL(2 + (kPairs - 2) / 15, whole);
}

TEST(SearchInWindows, WhatEntersOrComesBackIsFoundTwoPairsLaterAtMost) {
  int found = 0, lost = 0;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3 + i; ++k) Next({0, 1});
    found += with.StatusOf(1) == FixStatus::kTracked ? 1 : 0;
    for (int k = 0; k < 2 + i % 2; ++k) Next({0});
    lost += with.StatusOf(1) == FixStatus::kTracked ? 0 : 1;
  }
  LONGS_EQUAL(4, found);
  LONGS_EQUAL(4, lost);
  CHECK(longest_late > 0 && longest_late <= 2);
}

TEST(SearchInWindows, WhatCameBackStaysFound) {
  for (int k = 0; k < 3; ++k) Next({0, 1});
  for (int k = 0; k < 3; ++k) Next({0});
  for (int k = 0; k < 3; ++k) Next({0, 1});
  for (int k = 0; k < 6; ++k) {
    Next({0, 1});
    CHECK(FixStatus::kTracked == with.StatusOf(1));
  }
}

TEST(SearchInWindows, WhatHasAHiddenLedStaysFound) {
  for (int k = 0; k < 3; ++k) Next({0, 1});
  hidden_led = 1;
  for (int k = 0; k < 8; ++k) {
    Next({0, 1});
    // The first pair without the LED was searched where it had been.
    if (k > 0) CHECK(FixStatus::kRecovered == with.StatusOf(1));
    CHECK(FixStatus::kRecovered == without.StatusOf(1));
  }
}

TEST(SearchInWindows, WithNothingFollowedEveryPairIsSearchedAllOver) {
  for (int i = 0; i < 6; ++i) {
    Next({});
    CHECK(with.Whole());
  }
}

TEST(SearchInWindows, AnOldPlanIsNoPlan) {
  for (int i = 0; i < 3; ++i) Next({0, 1});
  pair += 12;  // 200 ms
  Next({0, 1});
  CHECK(with.Whole());
  CHECK(FixStatus::kTracked == with.StatusOf(0));
}
