#include "firmware/detect/detector.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/allocation_guard.h"
#include "tests/support/centroid_trials.h"
#include "tests/support/rendered_spots.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::CameraFrame;
using adit::base::FrameStatus;
using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::detect::Detector;
using adit::support::kTrialBackgroundDn;
using adit::support::kTrialHeightPx;
using adit::support::kTrialWidthPx;
using adit::support::Measure;
using adit::support::Nearest;
using adit::support::Pinhole;
using adit::support::RenderedImage;
using adit::support::RenderedSpot;
using adit::support::SensorNoise;
using adit::support::TrialErrors;

const SensorNoise kNoiseA;

/// 8 x 7 spots 42 px apart, each at a random phase.
std::vector<RenderedSpot> Grid(std::mt19937& random, double peak_dn, double sigma_px) {
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  std::vector<RenderedSpot> spots;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column < 8; ++column)
      spots.push_back(
          {40 + 42.0 * column + phase(random), 30 + 42.0 * row + phase(random), sigma_px, peak_dn});
  }
  return spots;
}

}  // namespace

TEST_GROUP(Detector) {
  std::unique_ptr<BlobSet> out = std::make_unique<BlobSet>();

  /// Detects one image of these spots with noise of seed 1.
  void Detect(const std::vector<RenderedSpot>& spots) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx);
    image.Background(kTrialBackgroundDn);
    for (const RenderedSpot& spot : spots) image.Add(spot);
    std::mt19937 random(1);
    image.Expose(kNoiseA, &random);
    Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
  }
};

TEST(Detector, ReachesTheCramerRaoBoundAndStatesItsErrorHonestly_Seeds1To12) {
  unsigned seed = 0;
  for (const int bits : {8, 12}) {
    for (const double sigma_px : {1.2, 2.5}) {
      for (const double peak_dn : {50.0, 100.0, 200.0}) {
        const TrialErrors errors =
            Measure({.peak_dn = peak_dn, .sigma_px = sigma_px, .bits = bits}, 10, ++seed);
        LONGS_EQUAL(0, errors.missing + errors.surplus);
        CHECK(errors.PerBound() < 1.10);
        // A pair's squared normalised error has the mean 2 and the variance 4: 560 are good to 0.085.
        CHECK(errors.nees > 1.75 && errors.nees < 2.25);
      }
    }
  }
}

TEST(Detector, CentroidsWithoutNoiseAreWithinFiveThousandthsOfAPixel) {
  std::mt19937 random(10);
  RenderedImage image(kTrialWidthPx, kTrialHeightPx);
  image.Background(kTrialBackgroundDn);
  const auto spots = Grid(random, 200, 1.6);
  for (const RenderedSpot& spot : spots) image.Add(spot);
  image.Expose(kNoiseA, nullptr);
  Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
  for (const RenderedSpot& spot : spots) {
    const Blob* const blob = Nearest(*out, spot);
    CHECK(blob != nullptr);
    DOUBLES_EQUAL(spot.x_px, blob->raw_px.x(), 0.005);
    DOUBLES_EQUAL(spot.y_px, blob->raw_px.y(), 0.005);
  }
}

TEST(Detector, SaturatedSpotsSaySo) {
  Detect({{100.3, 100.2, 1.6, 400}, {200.1, 100.4, 1.6, 150}});
  const Blob* const clipped = Nearest(*out, {100.3, 100.2});
  const Blob* const whole = Nearest(*out, {200.1, 100.4});
  CHECK(clipped != nullptr && whole != nullptr);
  CHECK(clipped->saturated);
  CHECK_FALSE(whole->saturated);
  CHECK((clipped->raw_px - Eigen::Vector2d(100.3, 100.2)).norm() < 0.04);
}

TEST(Detector, CountsWhatItLeavesOut) {
  RenderedImage image(kTrialWidthPx, kTrialHeightPx);
  image.Background(kTrialBackgroundDn);
  image.Add({100, 100, 0.35, 60});                                       // a hot pixel
  image.Add({200, 150, 12, 220});                                        // a headlight
  image.Add({1, 200, 1.6, 200});                                         // cut by the border
  for (int i = 0; i < 12; ++i) image.Add({300 + 1.5 * i, 60, 1.3, 90});  // a lit edge
  image.Add({320, 250, 1.6, 200});                                       // an LED
  image.Expose(kNoiseA, nullptr);
  Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
  LONGS_EQUAL(1, out->blobs.size());
  LONGS_EQUAL(1, out->rejects.too_small);
  LONGS_EQUAL(1, out->rejects.too_large);
  LONGS_EQUAL(1, out->rejects.at_border);
  LONGS_EQUAL(1, out->rejects.not_round);
  // An LED may have merged with any of them but the hot pixel.
  const auto is_in_a_region = [this](int x_px, int y_px) {
    return std::any_of(out->regions.begin(), out->regions.end(), [&](const adit::detect::Window& box) {
      return x_px >= box.x_min_px && x_px <= box.x_max_px && y_px >= box.y_min_px && y_px <= box.y_max_px;
    });
  };
  LONGS_EQUAL(3, out->regions.size());
  for (const auto& [x_px, y_px] : {std::pair{195, 145}, std::pair{1, 200}, std::pair{316, 60}})
    CHECK(is_in_a_region(x_px, y_px));
  CHECK_FALSE(is_in_a_region(320, 250));
  CHECK(Nearest(*out, {320, 250}) != nullptr);
}

TEST(Detector, TwelveBitsGiveTheSameCentroidsAsEight) {
  const RenderedSpot spot{200.3, 160.2, 1.6, 150};
  const auto detect = [&](int bits, int padding_bytes) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx, bits, padding_bytes);
    image.Background(kTrialBackgroundDn);
    image.Add(spot);
    image.Expose(kNoiseA, nullptr);
    Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
    LONGS_EQUAL(1, out->blobs.size());
    return out->blobs[0];
  };
  const Blob eight = detect(8, 0), padded = detect(8, 56), twelve = detect(12, 0), ten = detect(10, 24);
  CHECK((eight.raw_px - padded.raw_px).norm() == 0);
  CHECK((eight.raw_px - twelve.raw_px).norm() < 0.01);
  CHECK((eight.raw_px - ten.raw_px).norm() < 0.01);
  DOUBLES_EQUAL(eight.peak_dn, twelve.peak_dn / 16, 1);
  // The last bit's rounding is the only noise that differs.
  DOUBLES_EQUAL(1, eight.covariance_px2(0, 0) / twelve.covariance_px2(0, 0), 0.1);
}

TEST(Detector, RefusesWhatItCannotRead) {
  RenderedImage image(kTrialWidthPx, kTrialHeightPx);
  image.Add({200, 160, 1.6, 200});
  image.Expose(kNoiseA, nullptr);
  const auto status = [&](const CameraFrame& frame) {
    Detector(Pinhole(), {}).Detect(frame, {}, *out);
    LONGS_EQUAL(0, out->blobs.size());
    return out->stamp.status;
  };
  CameraFrame frame = image.Frame();
  frame.stamp.status = FrameStatus::kIncomplete;
  CHECK(FrameStatus::kIncomplete == status(frame));
  frame = image.Frame();
  frame.image.width_px -= 1;
  CHECK(FrameStatus::kWrongSize == status(frame));
  frame = image.Frame();
  frame.image.data = nullptr;
  CHECK(FrameStatus::kWrongSize == status(frame));
  for (const int bits : {0, 7, 13, 16}) {
    frame = image.Frame();
    frame.image.bits = bits;
    CHECK(FrameStatus::kWrongFormat == status(frame));
  }
}

TEST(Detector, MoreSpotsThanItKeepsAreCounted) {
  constexpr int kSide = 640;
  RenderedImage image(kSide, kSide);
  image.Background(kTrialBackgroundDn);
  for (int row = 0; row < 30; ++row)
    for (int column = 0; column < 30; ++column) image.Add({20 + 20.0 * column, 20 + 20.0 * row, 1.5, 150});
  image.Expose(kNoiseA, nullptr);
  Detector(Pinhole(kSide, kSide), {}).Detect(image.Frame(), {}, *out);
  LONGS_EQUAL(adit::detect::kMaxBlobs, out->blobs.size());
  LONGS_EQUAL(900 - adit::detect::kMaxBlobs, out->rejects.no_room);
}

TEST(Detector, UndistortsPlaceAndCovariance) {
  adit::optics::CameraModel camera = Pinhole();
  camera.fu_px = camera.fv_px = 400;
  camera.k1 = -0.2;
  const RenderedSpot spot{330.3, 260.2, 1.6, 150};
  RenderedImage image(kTrialWidthPx, kTrialHeightPx);
  image.Background(kTrialBackgroundDn);
  image.Add(spot);
  image.Expose(kNoiseA, nullptr);
  Detector(camera, {}).Detect(image.Frame(), {}, *out);
  LONGS_EQUAL(1, out->blobs.size());
  const Blob blob = out->blobs[0];
  // r' = r (1 + k1 r^2), inverted by bisection along the ray from the centre.
  const Eigen::Vector2d ray = (blob.raw_px - Eigen::Vector2d(200, 160)) / 400;
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double r = (low + high) / 2;
    (r * (1 - 0.2 * r * r) < ray.norm() ? low : high) = r;
  }
  const Eigen::Vector2d ideal_px = Eigen::Vector2d(200, 160) + 400 * low * ray.normalized();
  CHECK((blob.ideal_px - ideal_px).norm() < 1e-9);
  // Barrel: the corner is stretched when it is undone, along the ray by 1 / (1 + 3 k1 r^2).
  const double stretch = 1 / (1 - 3 * 0.2 * low * low);
  Detector(Pinhole(), {}).Detect(image.Frame(), {}, *out);
  const Eigen::Vector2d along = ray.normalized();
  const double plain_px2 = along.dot(out->blobs[0].covariance_px2 * along);
  DOUBLES_EQUAL(stretch * stretch, along.dot(blob.covariance_px2 * along) / plain_px2, 1e-6);
}

TEST(Detector, AllocatesNothingAfterItsConstruction) {
  if (!adit::support::CountsAllocations()) return;
  std::mt19937 random(11);
  RenderedImage image(kTrialWidthPx, kTrialHeightPx);
  image.Background(kTrialBackgroundDn);
  for (const RenderedSpot& spot : Grid(random, 150, 1.6)) image.Add(spot);
  image.Expose(kNoiseA, &random);
  Detector detector(Pinhole(), {});
  const std::uint64_t before = adit::support::AllocationCount();
  detector.Detect(image.Frame(), {}, *out);
  const std::uint64_t after = adit::support::AllocationCount();
  LONGS_EQUAL(56, out->blobs.size());
  LONGS_EQUAL(before, after);
}
