// From two images to fixes, many times: what a box does all day must not touch the heap.
#include <memory>
#include <random>

#include "firmware/pipeline/pipeline.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/rendered_spots.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::Side;
using adit::support::RenderedImage;

constexpr int kPairs = 12, kLamps = 40;

/// What one camera sees of the bar and of lamps that stand where `lamps` says.
RenderedImage Render(const adit::support::SyntheticCamera& camera, const adit::support::SyntheticBar& bar,
                     unsigned lamps, std::mt19937& noise) {
  RenderedImage image(camera.width_px, camera.height_px);
  image.Background(8);
  for (const double place_m : bar.target.leds_m) {
    const Eigen::Vector2d raw_px = camera.Distorted(*camera.ProjectIdeal(bar.Point(place_m)));
    image.Add({raw_px.x(), raw_px.y(), 1.6, 180});
  }
  std::mt19937 random(lamps);
  std::uniform_real_distribution<double> x(20, camera.width_px - 20), y(20, camera.height_px - 20);
  for (int i = 0; i < kLamps; ++i) image.Add({x(random), y(random), 2.0, 150});
  image.Expose({}, &noise);
  return image;
}

}  // namespace

TEST_GROUP(HotPath){};

TEST(HotPath, FromTwoImagesToFixesWithoutTheHeap_Seed12) {
  const auto rig = adit::support::ToedInRig();
  const auto target = adit::support::SeedTargetOne();
  auto pipeline = adit::pipeline::Pipeline::Make(rig.AsRig(), {adit::support::ModelOf(target, 20)}, {});
  CHECK(pipeline.operator bool());
  auto left = std::make_unique<adit::detect::BlobSet>(), right = std::make_unique<adit::detect::BlobSet>();
  auto result = std::make_unique<adit::pipeline::PairResult>();
  std::mt19937 noise(12);
  std::uint64_t heap_calls = 0;
  int in_windows = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    const auto bar = adit::support::SyntheticBar::At(target, adit::support::Ahead(rig, 30 + pair),
                                                     Eigen::Vector3d(0.9, 0.3, 0.1 * pair / kPairs));
    const RenderedImage left_image = Render(rig.left, bar, 1, noise),
                        right_image = Render(rig.right, bar, 2, noise);
    adit::base::CameraFrame left_frame = left_image.Frame(), right_frame = right_image.Frame();
    right_frame.stamp.side = Side::kRight;
    left_frame.stamp.mid_exposure_ns = right_frame.stamp.mid_exposure_ns = 1 + pair * 16'666'667LL;
    const std::uint64_t before = adit::support::AllocationCount();
    pipeline->Detect(left_frame, *left);
    pipeline->Detect(right_frame, *right);
    pipeline->Locate(*left, *right, *result);
    heap_calls += adit::support::AllocationCount() - before;
    // It did the work that it is measured for.
    CHECK(!left->whole || left->blobs.size() > 35);
    CHECK(!right->whole || right->blobs.size() > 35);
    in_windows += left->whole ? 0 : 1;
    const auto& fix = result->fixes.targets[0];
    CHECK(adit::stereo::FixStatus::kTracked == fix.state.points.status);
    CHECK((fix.state.points.epicenter_b_m - bar.Epicenter()).norm() < 0.02);
  }
  LONGS_EQUAL(0, heap_calls);
  CHECK(in_windows > 3 && in_windows < kPairs - 1);
}
