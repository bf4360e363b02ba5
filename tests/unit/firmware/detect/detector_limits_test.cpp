// The detection at the edges of what it is made for: faint, clipped, merged and uneven light, borders, full
// tables.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "firmware/detect/components.h"
#include "firmware/detect/detector.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/centroid_trials.h"
#include "tests/support/rendered_spots.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::FrameStatus;
using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::detect::Components;
using adit::detect::Detector;
using adit::support::kTrialBackgroundDn;
using adit::support::kTrialHeightPx;
using adit::support::kTrialWidthPx;
using adit::support::Measure;
using adit::support::Nearest;
using adit::support::Pinhole;
using adit::support::RenderedImage;
using adit::support::RenderedSpot;
using adit::support::TrialErrors;

}  // namespace

TEST_GROUP(DetectorLimits) {
  std::unique_ptr<BlobSet> out = std::make_unique<BlobSet>();

  void Detect(const std::vector<RenderedSpot>& spots) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx);
    image.Background(kTrialBackgroundDn);
    for (const RenderedSpot& spot : spots) image.Add(spot);
    image.Expose({}, nullptr);
    Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
  }
};

TEST(DetectorLimits, FaintAndNearlyClippedSpotsAreAtTheBoundToo_Seeds21To24) {
  unsigned seed = 20;
  for (const double sigma_px : {1.6, 2.2}) {
    for (const double peak_dn : {30.0, 235.0}) {
      const TrialErrors errors = Measure({.peak_dn = peak_dn, .sigma_px = sigma_px}, 10, ++seed);
      LONGS_EQUAL(0, errors.missing);
      CHECK(errors.PerBound() < 1.10);
      CHECK(errors.nees > 1.75 && errors.nees < 2.25);
    }
  }
}

TEST(DetectorLimits, SpotsOfOnePixelCostMoreButSaySo_Seeds25And26) {
  unsigned seed = 24;
  for (const double peak_dn : {75.0, 200.0}) {
    const TrialErrors errors = Measure({.peak_dn = peak_dn, .sigma_px = 0.8}, 10, ++seed);
    LONGS_EQUAL(0, errors.missing);
    CHECK(errors.PerBound() < 1.2);
    CHECK(errors.nees > 1.5 && errors.nees < 2.8);
  }
}

TEST(DetectorLimits, ALitRockFaceShiftsNoCentroid_Seeds31To33) {
  unsigned seed = 30;
  for (const double slope_dn : {0.0, 0.02, 0.05}) {  // 28 DN from corner to corner
    const TrialErrors errors = Measure({.peak_dn = 150, .sigma_px = 1.6, .slope_dn = slope_dn}, 10, ++seed);
    LONGS_EQUAL(0, errors.missing);
    // 560 spots: the mean is good to 0.001 px.
    CHECK(errors.offset_px < 0.006);
    CHECK(errors.PerBound() < 1.15);
    CHECK(errors.nees > 1.75 && errors.nees < 2.4);
  }
}

TEST(DetectorLimits, TwoSpotsThatApproachEachOtherAreTwoAndThenOneBetweenThem) {
  for (const double sigma_px : {1.2, 1.6, 2.0}) {
    for (double gap = 0; gap < 8; gap += 0.25) {  // in sigmas
      const RenderedSpot a{200.13 - gap * sigma_px / 2, 160.3, sigma_px, 200};
      const RenderedSpot b{200.13 + gap * sigma_px / 2, 160.3, sigma_px, 200};
      Detect({a, b});
      CHECK(out->blobs.size() == 2 || gap < 1.75);
      CHECK(out->blobs.size() == 1 || gap > 1.25);
      if (out->blobs.size() == 1) {
        CHECK((out->blobs[0].raw_px - Eigen::Vector2d(200.13, 160.3)).norm() < 0.02);
        continue;
      }
      CHECK((out->blobs[0].raw_px - Eigen::Vector2d(a.x_px, a.y_px)).norm() < 0.05);
      CHECK((out->blobs[1].raw_px - Eigen::Vector2d(b.x_px, b.y_px)).norm() < 0.05);
    }
  }
}

TEST(DetectorLimits, SpotsThatTouchABorderAreCountedNotMeasured) {
  constexpr double kRight = kTrialWidthPx - 1, kBottom = kTrialHeightPx - 1;
  const std::array<RenderedSpot, 8> cut{{{1, 100},
                                         {kRight - 1, 100},
                                         {200, 1},
                                         {200, kBottom - 1},
                                         {0, 0},
                                         {kRight, 0},
                                         {0, kBottom},
                                         {kRight, kBottom}}};
  for (const RenderedSpot& spot : cut) {
    Detect({spot, {100.2, 200.4}});
    LONGS_EQUAL(1, out->blobs.size());
    LONGS_EQUAL(1, out->rejects.at_border);
    CHECK(Nearest(*out, {100.2, 200.4}) != nullptr);
  }
  // One pixel of dark before the border is enough: a spot of sigma 1.5 and 200 DN is bright up to 3.5 px.
  for (const RenderedSpot& spot : {RenderedSpot{5.2, 100}, RenderedSpot{kRight - 5.2, 100},
                                   RenderedSpot{200, 5.2}, RenderedSpot{200, kBottom - 5.2}}) {
    Detect({spot});
    LONGS_EQUAL(1, out->blobs.size());
    LONGS_EQUAL(0, out->rejects.at_border);
  }
}

TEST(DetectorLimits, AnImageWithMoreRunsThanThereIsRoomForHasNoBlobs) {
  constexpr int kWide = 1400, kHigh = 1024;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kWide) * kHigh, 10);
  // Columns that the background's sample of every 8th pixel does not meet.
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i % 2 == 1 ? 200 : 10;
  adit::base::CameraFrame frame;
  frame.image = {pixels.data(), kWide, kHigh, kWide, 8};
  Detector detector(Pinhole(kWide, kHigh), {});
  detector.Detect(frame, {}, *out);
  static_assert(static_cast<std::size_t>(kWide) / 2 * kHigh > Components::kMaxRuns);
  LONGS_EQUAL(0, out->blobs.size());
  LONGS_EQUAL(1, out->rejects.no_room);
  CHECK(FrameStatus::kOk == out->stamp.status);
  // The next image is detected as if nothing had been.
  std::fill(pixels.begin(), pixels.end(), std::uint8_t{10});
  for (std::size_t y = 500; y < 504; ++y) std::memset(&pixels[y * kWide + 700], 200, 4);
  detector.Detect(frame, {}, *out);
  LONGS_EQUAL(1, out->blobs.size());
  LONGS_EQUAL(0, out->rejects.no_room);
  CHECK((out->blobs[0].raw_px - Eigen::Vector2d(701.5, 501.5)).norm() < 1e-9);
}

TEST(DetectorLimits, RowsThatOverlapAreRefused) {
  for (const int bits : {8, 12}) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx, bits);
    image.Add({200, 160});
    image.Expose({}, nullptr);
    Detector detector(Pinhole(), {});
    auto frame = image.Frame();
    detector.Detect(frame, {}, *out);
    LONGS_EQUAL(1, out->blobs.size());
    for (const std::ptrdiff_t stride_bytes :
         {frame.image.stride_bytes - 1, std::ptrdiff_t{0}, std::ptrdiff_t{-400}}) {
      frame.image.stride_bytes = stride_bytes;
      detector.Detect(frame, {}, *out);
      CHECK(FrameStatus::kWrongSize == out->stamp.status);
      LONGS_EQUAL(0, out->blobs.size());
    }
  }
}

TEST(DetectorLimits, NothingIsBrighterThanAGroundNearFullScale_Seed34) {
  std::mt19937 random(34);
  for (const double level_dn : {248.0, 255.0, 400.0}) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx);
    image.Background(level_dn);
    image.Add({200, 160});
    image.Expose({}, &random);
    Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
    LONGS_EQUAL(0, out->blobs.size());
    CHECK(out->threshold_dn <= 255);
  }
}

TEST(DetectorLimits, PixelsBeyondTheirDepthAreNotAllBright) {
  // 12 bits of a camera that is taken for one of 10: the ground is above the full scale of 10.
  RenderedImage image(kTrialWidthPx, kTrialHeightPx, 12);
  image.Background(100);
  image.Add({200.3, 160.2, 1.6, 100});
  image.Expose({}, nullptr);
  auto frame = image.Frame();
  frame.image.bits = 10;
  Detector(Pinhole(), {}).Detect(frame, {}, *out);
  CHECK(out->background_dn > 1023);
  CHECK(out->threshold_dn > out->background_dn);
  LONGS_EQUAL(1, out->blobs.size());
  CHECK((out->blobs[0].raw_px - Eigen::Vector2d(200.3, 160.2)).norm() < 0.02);
}

TEST(DetectorLimits, TheHeapStaysUntouchedWhateverTheImage_Seed35) {
  if (!adit::support::CountsAllocations()) return;
  std::uint64_t before = adit::support::AllocationCount();
  const auto one = std::make_unique<int>(1);
  CHECK(adit::support::AllocationCount() > before);  // it counts
  std::mt19937 random(35);
  RenderedImage noise(kTrialWidthPx, kTrialHeightPx), lamps(kTrialWidthPx, kTrialHeightPx),
      dark(kTrialWidthPx, kTrialHeightPx), fits(kTrialWidthPx, kTrialHeightPx);
  noise.Expose({80, 1}, &random);
  for (int n = 0; n < 600; ++n) lamps.Add({8 + 13.0 * (n % 30), 8 + 15.0 * (n / 30)});
  lamps.Expose({}, nullptr);
  dark.Expose({}, nullptr);
  // All ways of a fit: merged, near each other, clipped, smeared.
  for (int n = 0; n < 6; ++n) {
    fits.Add({60.0, 40 + 40.0 * n}), fits.Add({64.0, 41 + 40.0 * n});
    fits.Add({140.0, 40 + 40.0 * n}), fits.Add({148.5, 41 + 40.0 * n});
    fits.Add({220.0, 40 + 40.0 * n, 1.5, 500});
    fits.Add({300.0, 40 + 40.0 * n, 1.5, 200, 4, 3});
  }
  fits.Expose({}, &random);
  Detector detector(Pinhole(), {});
  std::size_t blobs = 0, surplus_lamps = 0;
  before = adit::support::AllocationCount();
  for (const RenderedImage* const image : {&noise, &lamps, &dark, &fits, &lamps}) {
    detector.Detect(image->Frame(), {}, *out);
    blobs += out->blobs.size();
    if (image == &lamps) surplus_lamps += out->rejects.no_room;
  }
  const std::uint64_t after = adit::support::AllocationCount();
  LONGS_EQUAL(before, after);
  CHECK(blobs >= 2 * adit::detect::kMaxBlobs);
  LONGS_EQUAL(2 * (600 - adit::detect::kMaxBlobs), surplus_lamps);
}
