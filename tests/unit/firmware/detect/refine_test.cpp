// LEDs that merge, disturb each other, clip or are smeared: two where there are two, and covariances that are
// true.
#include "firmware/detect/refine.h"

#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <random>

#include "firmware/detect/detector.h"
#include "tests/support/centroid_trials.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::support::Measure;
using adit::support::RenderedImage;
using adit::support::RenderedSpot;
using adit::support::TrialErrors;
using adit::support::TrialKind;

/// `images` of each kind have all their LEDs and nothing else, near the bound, with a true covariance.
void CheckAtTheBound(const TrialKind& kind, int images, unsigned seed) {
  const TrialErrors errors = Measure(kind, images, seed);
  LONGS_EQUAL(0, errors.missing + errors.surplus);
  CHECK(errors.PerBound() < 1.10);
  // Of `found` places: the mean of what has the mean 2 and the variance 4, three deviations either way.
  const double scatter = 3 * 2 / std::sqrt(errors.spots);
  CHECK(errors.nees > 2 - scatter && errors.nees < 2 + scatter);
}

/// The blobs of these spots with the noise of `seed`.
std::unique_ptr<BlobSet> Detect(const std::vector<RenderedSpot>& spots, unsigned seed) {
  RenderedImage image(adit::support::kTrialWidthPx, adit::support::kTrialHeightPx);
  image.Background(adit::support::kTrialBackgroundDn);
  for (const RenderedSpot& spot : spots) image.Add(spot);
  std::mt19937 random(seed);
  image.Expose({}, &random);
  auto blobs = std::make_unique<BlobSet>();
  adit::detect::Detector(adit::support::Pinhole(), {}).Detect(image.Frame(), {}, *blobs);
  return blobs;
}

}  // namespace

TEST_GROUP(Refine){};

TEST(Refine, FitsTwoThatMergedTogether_Seeds41To48) {
  unsigned seed = 40;
  for (const int bits : {8, 12})
    for (const double gap_px : {3.0, 4.5, 6.0})
      CheckAtTheBound({.peak_dn = 200, .sigma_px = 1.5, .gap_px = gap_px, .bits = bits}, 4, ++seed);
  CheckAtTheBound({.peak_dn = 100, .sigma_px = 1.5, .gap_px = 3, .second_peak = 0.6}, 4, ++seed);
  CheckAtTheBound({.peak_dn = 200, .sigma_px = 2.5, .gap_px = 9}, 4, ++seed);
}

TEST(Refine, FitsTwoThatDisturbEachOtherTogether_Seeds49To51) {
  unsigned seed = 48;
  for (const double gap_px : {8.0, 9.0, 11.0})
    CheckAtTheBound({.peak_dn = 200, .sigma_px = 1.5, .gap_px = gap_px}, 4, ++seed);
}

TEST(Refine, FitsClippedOnesByTheirRims_Seeds52To57) {
  unsigned seed = 51;
  for (const int bits : {8, 12})
    for (const double sigma_px : {1.2, 2.5})
      CheckAtTheBound({.peak_dn = 400, .sigma_px = sigma_px, .bits = bits}, 8, ++seed);
  CheckAtTheBound({.peak_dn = 900, .sigma_px = 1.5}, 8, ++seed);
  CheckAtTheBound({.peak_dn = 400, .sigma_px = 1.5, .gap_px = 4}, 4, ++seed);
}

TEST(Refine, SmearedOnesStayOne_Seeds58To61) {
  unsigned seed = 57;
  for (const double smear_px : {2.0, 4.0, 6.0})
    CheckAtTheBound({.peak_dn = 200, .smear_px = smear_px}, 8, ++seed);
  CheckAtTheBound({.peak_dn = 500, .smear_px = 4}, 8, ++seed);
}

TEST(Refine, WhatMayBeOneSmearedOrTwoHasRoomForEither_Seeds62To161) {
  // Two of 40 DN and sigma 2 px only 3 px apart: one in two can be told from a smear.
  const RenderedSpot a{150.3, 160.2, 2, 40}, b{153.3, 160.2, 2, 40};
  int doubtful = 0;
  double nees = 0;
  for (unsigned seed = 62; seed < 162; ++seed) {
    const auto out = Detect({a, b}, seed);
    if (out->blobs.size() != 1) continue;
    // One LED's stated error is below a tenth of a pixel.
    const Blob& blob = out->blobs[0];
    if (blob.covariance_px2(0, 0) < 0.1) continue;
    ++doubtful;
    const Eigen::Vector2d error_px = blob.raw_px - Eigen::Vector2d(a.x_px, a.y_px);
    nees += error_px.dot(blob.covariance_px2.inverse() * error_px);
  }
  CHECK(doubtful > 20);
  // Along the two it is half the gap for certain, across them a normal error: 1 each.
  CHECK(nees / doubtful > 1 && nees / doubtful < 3);
}

TEST(Refine, TwoOfARegionSaySoAndShareIt_Seed162) {
  const auto out =
      Detect({{150.3, 160.2, 1.5, 200}, {154.6, 161.9, 1.5, 120}, {250.2, 160.4, 1.5, 200}}, 162);
  LONGS_EQUAL(3, out->blobs.size());
  const Blob &left = out->blobs[0], &right = out->blobs[1], &alone = out->blobs[2];
  CHECK(left.merged && right.merged && !alone.merged);
  CHECK(left.x_min_px == right.x_min_px && left.x_max_px == right.x_max_px);
  // A pixel is the integral over its square: the Gaussian of the fit is wider by its moment, and lower.
  const double wider = 1 + 1.0 / 12 / (1.5 * 1.5);
  DOUBLES_EQUAL(200 / wider, left.peak_dn - 8, 6);
  DOUBLES_EQUAL(120 / wider, right.peak_dn - 8, 6);
  DOUBLES_EQUAL(1.5 * std::sqrt(wider), left.sigma_major_px, 0.05);
  DOUBLES_EQUAL(2 * M_PI * 1.5 * 1.5 * 200, left.flux_dn, 0.05 * left.flux_dn);
  DOUBLES_EQUAL(alone.flux_dn, left.flux_dn, 0.15 * left.flux_dn);
}

TEST(Refine, ALampBesideAnLedMakesNoSecondLedOfIt_Seed163) {
  // A lamp 12 px wide at full scale, its edge 6 px from the LED's middle.
  std::vector<RenderedSpot> spots{{148.8, 160.2, 1.5, 150}};
  for (int y = -6; y <= 6; ++y)
    for (int x = -6; x <= 6; ++x)
      if (x * x + y * y <= 36) spots.push_back({161.0 + x, 160.0 + y, 0.5, 900});
  const auto out = Detect(spots, 163);
  LONGS_EQUAL(2, out->blobs.size());
  const Blob& led = *adit::support::Nearest(*out, spots[0]);
  CHECK(!led.merged);
  const Eigen::Vector2d error_px = led.raw_px - Eigen::Vector2d(spots[0].x_px, spots[0].y_px);
  CHECK(error_px.norm() < 0.15);
}
