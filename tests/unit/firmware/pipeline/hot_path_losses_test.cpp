// The heap stays untouched too when a bar goes and comes back: covered LEDs, frames that are missing,
// darkness, more lamps than there is room for.
#include <memory>
#include <vector>

#include "firmware/pipeline/pipeline.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/rendered_spots.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::CameraFrame;
using adit::base::FrameStatus;
using adit::base::Side;
using adit::stereo::FixStatus;
using adit::support::RenderedImage;
using adit::support::SyntheticBar;
using adit::support::SyntheticCamera;

/// What stands before a camera: the bar's LEDs that are not covered, and lamps in a lattice.
struct View {
  std::vector<std::size_t> leds{0, 1, 2, 3};
  int lamps = 0;
  FrameStatus status = FrameStatus::kOk;
};

RenderedImage Render(const SyntheticCamera& camera, const SyntheticBar& bar, const View& view) {
  RenderedImage image(camera.width_px, camera.height_px);
  image.Background(8);
  for (const std::size_t led : view.leds) {
    const Eigen::Vector2d raw_px = camera.Distorted(*camera.ProjectIdeal(bar.Point(bar.target.leds_m[led])));
    image.Add({raw_px.x(), raw_px.y(), 1.6, 180});
  }
  constexpr int kColumns = 45, kStepPx = 30;
  for (int i = 0; i < view.lamps; ++i)
    image.Add({20.3 + kStepPx * (i % kColumns), 20.4 + kStepPx * (i / kColumns), 2, 150});
  image.Expose({}, nullptr);
  return image;
}

}  // namespace

TEST_GROUP(HotPathLosses) {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  adit::base::Target target = adit::support::SeedTargetOne();
  std::unique_ptr<adit::detect::BlobSet> left = std::make_unique<adit::detect::BlobSet>(),
                                         right = std::make_unique<adit::detect::BlobSet>();
  std::unique_ptr<adit::pipeline::PairResult> result = std::make_unique<adit::pipeline::PairResult>();
  adit::base::Result<adit::pipeline::Pipeline> pipeline =
      adit::pipeline::Pipeline::Make(rig.AsRig(), {adit::support::ModelOf(target, 20)}, {});
  std::uint64_t heap_calls = 0;
  int pair = 0;

  /// One more pair, the bar a little further on; what became of it.
  FixStatus Next(const View& in_left, const View& in_right) {
    const auto bar =
        SyntheticBar::At(target, Ahead(rig, 35 + 0.05 * pair), Eigen::Vector3d(0.9, 0.3, 0.002 * pair));
    const RenderedImage left_image = Render(rig.left, bar, in_left),
                        right_image = Render(rig.right, bar, in_right);
    CameraFrame left_frame = left_image.Frame(), right_frame = right_image.Frame();
    left_frame.stamp.status = in_left.status, right_frame.stamp.status = in_right.status;
    right_frame.stamp.side = Side::kRight;
    left_frame.stamp.mid_exposure_ns = right_frame.stamp.mid_exposure_ns = 1 + pair++ * 16'666'667LL;
    const std::uint64_t before = adit::support::AllocationCount();
    pipeline->Detect(left_frame, *left);
    pipeline->Detect(right_frame, *right);
    pipeline->Locate(*left, *right, *result);
    heap_calls += adit::support::AllocationCount() - before;
    const auto& points = result->fixes.targets[0].state.points;
    if (points.status == FixStatus::kTracked || points.status == FixStatus::kRecovered)
      CHECK((points.epicenter_b_m - bar.Epicenter()).norm() < 0.02);
    return points.status;
  }
  void Tracks(int pairs) {
    for (int i = 0; i < pairs; ++i) CHECK(FixStatus::kTracked == Next({}, {}));
  }
};

TEST(HotPathLosses, FramesThatAreMissingAndComeBack) {
  Tracks(4);
  CHECK(FixStatus::kTracked != Next({.status = FrameStatus::kIncomplete}, {}));
  CHECK(FixStatus::kTracked != Next({}, {.status = FrameStatus::kWrongSize}));
  Tracks(2);
  for (int i = 0; i < 4; ++i) CHECK(FixStatus::kTracked != Next({.leds = {}}, {.leds = {}}));
  LONGS_EQUAL(0, left->blobs.size() + right->blobs.size());
  Tracks(2);
  LONGS_EQUAL(0, heap_calls);
}

TEST(HotPathLosses, CoveredLedsAreNotReportedAsMeasured) {
  for (std::size_t covered = 0; covered < 4; ++covered) {
    View partly;
    partly.leds.erase(partly.leds.begin() + static_cast<std::ptrdiff_t>(covered));
    Tracks(1);
    CHECK(FixStatus::kTracked != Next(partly, {}));
    Tracks(1);
    CHECK(FixStatus::kTracked != Next({}, partly));
    LONGS_EQUAL(7, left->blobs.size() + right->blobs.size());
  }
  Tracks(1);
  LONGS_EQUAL(0, heap_calls);
}

TEST(HotPathLosses, MoreLampsThanThereIsRoomFor) {
  Tracks(3);
  for (int i = 0; i < 2; ++i) {
    do Next({.lamps = 900}, {.lamps = 1400});
    while (!left->whole || !right->whole);
    LONGS_EQUAL(adit::detect::kMaxBlobs, left->blobs.size());
    LONGS_EQUAL(adit::detect::kMaxBlobs, right->blobs.size());
    CHECK(left->rejects.no_room > 300 && right->rejects.no_room > 800);
  }
  Tracks(2);
  LONGS_EQUAL(0, heap_calls);
}

TEST(HotPathLosses, TheCountOfHeapCallsIsNotAlwaysNought) {
  if (!adit::support::CountsAllocations()) return;
  const std::uint64_t before = adit::support::AllocationCount();
  const auto image = RenderedImage(16, 16);
  CHECK(image.View().data != nullptr);
  CHECK(adit::support::AllocationCount() > before);
}
