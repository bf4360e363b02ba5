#include "firmware/detect/window.h"

#include <memory>
#include <random>

#include "firmware/detect/detector.h"
#include "tests/support/rendered_spots.h"

#include <CppUTest/TestHarness.h>

using adit::detect::Add;
using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::detect::Detector;
using adit::detect::Window;
using adit::detect::Windows;
using adit::support::RenderedImage;

namespace {

bool Inside(const Blob& blob, const Window& w) {
  return blob.x_min_px > w.x_min_px && blob.x_max_px < w.x_max_px && blob.y_min_px > w.y_min_px &&
         blob.y_max_px < w.y_max_px;
}

bool SameBits(const Blob& a, const Blob& b) {
  return a.raw_px == b.raw_px && a.ideal_px == b.ideal_px && a.covariance_px2 == b.covariance_px2 &&
         a.flux_dn == b.flux_dn && a.area_px == b.area_px && a.peak_dn == b.peak_dn;
}

}  // namespace

TEST_GROUP(Window){};

TEST(Window, ThoseThatOverlapBecomeOne) {
  Windows windows;
  CHECK(Add(windows, {0, 0, 10, 10}));
  CHECK(Add(windows, {20, 0, 30, 10}));
  CHECK(Add(windows, {11, 0, 19, 10}));  // touches neither
  LONGS_EQUAL(3, windows.size());
  // Overlaps the first only, but joined with it the second too.
  CHECK(Add(windows, {10, 10, 25, 12}));
  LONGS_EQUAL(1, windows.size());
  LONGS_EQUAL(0, windows[0].x_min_px);
  LONGS_EQUAL(30, windows[0].x_max_px);
  LONGS_EQUAL(12, windows[0].y_max_px);
}

TEST(Window, RandomOnesNeverOverlapAndCoverWhatWasAdded_Seed1) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    Windows windows;
    std::vector<Window> added;
    for (int i = 0; i < 20; ++i) {
      const int x = static_cast<int>(random() % 300), y = static_cast<int>(random() % 300);
      added.push_back({x, y, x + static_cast<int>(random() % 40), y + static_cast<int>(random() % 40)});
      CHECK(Add(windows, added.back()));
    }
    for (const Window& a : added) {
      bool covered = false;
      for (const Window& w : windows)
        covered = covered || (w.x_min_px <= a.x_min_px && a.x_max_px <= w.x_max_px &&
                              w.y_min_px <= a.y_min_px && a.y_max_px <= w.y_max_px);
      CHECK(covered);
    }
    for (const Window& a : windows)
      for (const Window& b : windows)
        CHECK(&a == &b || a.x_max_px < b.x_min_px || b.x_max_px < a.x_min_px || a.y_max_px < b.y_min_px ||
              b.y_max_px < a.y_min_px);
  }
}

TEST(Window, DeclinesWhenThereIsNoRoom) {
  Windows windows;
  for (int i = 0; i < static_cast<int>(adit::detect::kMaxWindows); ++i)
    CHECK(Add(windows, {10 * i, 0, 10 * i + 5, 5}));
  CHECK(!Add(windows, {10000, 0, 10005, 5}));
  CHECK(Add(windows, {0, 0, 15, 5}));  // joins two
}

TEST(Window, ItsBlobsAreBitForBitThoseOfTheWholeImage_Seed2) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> x_px(0, 600), y_px(0, 400), sigma_px(1, 4);
  RenderedImage image(600, 400);
  image.Background(8);
  for (int i = 0; i < 120; ++i) image.Add({x_px(random), y_px(random), sigma_px(random), 180});
  image.Expose({}, &random);
  adit::optics::CameraModel camera;
  camera.fu_px = camera.fv_px = 900, camera.cu_px = 300, camera.cv_px = 200, camera.k1 = -0.1;
  camera.width_px = 600, camera.height_px = 400;
  Detector detector(camera, {});
  auto whole = std::make_unique<BlobSet>(), parts = std::make_unique<BlobSet>();
  detector.Detect(image.Frame(), {}, *whole);
  CHECK(whole->whole);
  CHECK(whole->blobs.size() > 50);
  Windows windows;
  for (const Window& w : {Window{0, 0, 120, 90}, Window{150, 20, 340, 260}, Window{30, 300, 599, 399},
                          Window{410, 100, 470, 161}})
    CHECK(Add(windows, w));
  detector.Detect(image.Frame(), windows, *parts);
  CHECK_FALSE(parts->whole);
  std::size_t expected = 0;
  for (const Blob& blob : whole->blobs) {
    bool inside = false, found = false;
    for (const Window& w : windows) inside = inside || Inside(blob, w);
    for (const Blob& part : parts->blobs) found = found || SameBits(part, blob);
    CHECK_EQUAL(inside, found);
    expected += inside ? 1 : 0;
  }
  CHECK(expected > 20 && expected < whole->blobs.size());
  LONGS_EQUAL(expected, parts->blobs.size());
}
