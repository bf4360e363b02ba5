#include "firmware/identify/p2_invariant.h"

#include <cmath>

#include <CppUTest/TestHarness.h>

using adit::identify::CrossRatio;
using adit::identify::CrossRatioSlopes;
using adit::identify::LinePlaces;
using adit::identify::P2;
using adit::identify::P2Slope;

TEST_GROUP(P2Invariant){};

TEST(P2Invariant, HasTheSeedsValuesForItsTwoTargets) {
  DOUBLES_EQUAL(0.26154, CrossRatio({0, 0.25, 0.65, 1.50}), 5e-6);
  DOUBLES_EQUAL(2.2707, P2(CrossRatio({0, 0.25, 0.65, 1.50})), 5e-5);
  DOUBLES_EQUAL(0.175, CrossRatio({0, 0.25, 0.80, 1.50}), 1e-12);
  DOUBLES_EQUAL(2.1109, P2(0.175), 5e-5);
}

TEST(P2Invariant, LiesBetweenTwoAndTwoPointEight) {
  DOUBLES_EQUAL(2.0, P2(0), 1e-12);
  DOUBLES_EQUAL(2.8, P2(0.5), 1e-12);
  DOUBLES_EQUAL(2.8, P2(-1), 1e-12);
  for (int i = -500; i <= 500; ++i) {
    const double j = P2(0.013 * i);
    CHECK(j >= 2 - 1e-12);
    CHECK(j <= 2.8 + 1e-12);
  }
}

TEST(P2Invariant, IsTheSameForEveryOrderOfTheFourPoints) {
  for (const double lambda : {0.05, 0.175, 0.26154, 0.41}) {
    for (const double same :
         {1 - lambda, 1 / lambda, 1 / (1 - lambda), lambda / (lambda - 1), (lambda - 1) / lambda}) {
      DOUBLES_EQUAL(P2(lambda), P2(same), 1e-9);
    }
  }
}

TEST(P2Invariant, SurvivesProjectionAndReadingFromTheOtherEnd) {
  const LinePlaces places{0.1, 0.4, 0.75, 1.6};
  for (const double bend : {-0.3, -0.05, 0.02, 0.4}) {
    LinePlaces image, reversed;
    for (std::size_t i = 0; i < 4; ++i) image[i] = (7 + 300 * places[i]) / (1 + bend * places[i]);
    for (std::size_t i = 0; i < 4; ++i) reversed[i] = -image[3 - i];
    DOUBLES_EQUAL(CrossRatio(places), CrossRatio(image), 1e-12);
    DOUBLES_EQUAL(CrossRatio(places), CrossRatio(reversed), 1e-12);
  }
}

TEST(P2Invariant, ItsSlopesAgreeWithDifferences) {
  for (int i = 1; i < 50; ++i) {
    const double lambda = 0.02 * i, step = 1e-6;
    DOUBLES_EQUAL((P2(lambda + step) - P2(lambda - step)) / (2 * step), P2Slope(lambda), 1e-6);
  }
  const LinePlaces places{1, 30, 71, 160};
  const LinePlaces slopes = CrossRatioSlopes(places);
  for (std::size_t i = 0; i < 4; ++i) {
    LinePlaces up = places, down = places;
    up[i] += 1e-4, down[i] -= 1e-4;
    DOUBLES_EQUAL((CrossRatio(up) - CrossRatio(down)) / 2e-4, slopes[i], 1e-9);
  }
}

TEST(P2Invariant, IsNoNumberThatPassesWhenPointsCoincide) {
  const double j = P2(CrossRatio({5, 5, 5, 5}));
  CHECK_FALSE(j >= 2 && j <= 2.8);
}
