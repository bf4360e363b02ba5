#include "firmware/detect/background.h"

#include <random>

#include "tests/support/rendered_spots.h"

#include <CppUTest/TestHarness.h>

using adit::detect::Background;
using adit::detect::EstimateBackground;
using adit::support::RenderedImage;

namespace {

Background Estimate(double level_dn, double read_dn, int bits, unsigned seed) {
  std::mt19937 random(seed);
  RenderedImage image(1400, 512, bits, 24);
  image.Background(level_dn);
  image.Expose({read_dn, 1e9}, &random);
  return EstimateBackground(image.View());
}

}  // namespace

TEST_GROUP(Background){};

TEST(Background, IsTheLevelAndTheNoiseThatWereRendered_Seeds1To6) {
  unsigned seed = 0;
  for (const double level_dn : {20.0, 100.0, 200.0}) {
    for (const double read_dn : {1.5, 5.0}) {
      const Background found = Estimate(level_dn, read_dn, 8, ++seed);
      // 2800 samples: the median is good to 0.024 sigma, the distance to the quantile to 0.03 sigma (1 sigma
      // each).
      DOUBLES_EQUAL(level_dn, found.level_dn, 0.1 * read_dn);
      DOUBLES_EQUAL(std::hypot(read_dn, std::sqrt(1.0 / 12)), found.noise_dn, 0.1 * read_dn);
    }
  }
}

TEST(Background, IsInTheUnitsOfTheImagesDepth_Seed7) {
  const Background eight = Estimate(20, 2, 8, 7), ten = Estimate(20, 2, 10, 7),
                   twelve = Estimate(20, 2, 12, 7);
  DOUBLES_EQUAL(4 * eight.level_dn, ten.level_dn, 4 * 0.2);
  DOUBLES_EQUAL(16 * eight.level_dn, twelve.level_dn, 16 * 0.2);
  DOUBLES_EQUAL(16 * 2, twelve.noise_dn, 16 * 0.2);
}

TEST(Background, OfAnEvenImageIsItsValueWithLittleNoise) {
  for (const int value : {0, 1, 77, 255}) {
    RenderedImage image(200, 100);
    image.Background(value);
    image.Expose({}, nullptr);
    const Background found = EstimateBackground(image.View());
    DOUBLES_EQUAL(value, found.level_dn, 0.01);
    CHECK(found.noise_dn < 0.5);
  }
}

TEST(Background, LightsOverASeventhOfTheImageMoveItLittle_Seed8) {
  std::mt19937 random(8);
  RenderedImage image(1400, 512);
  image.Background(20);
  image.Expose({2, 1e9}, &random);
  const Background dark = EstimateBackground(image.View());
  std::uniform_real_distribution<double> x_px(0, 1400), y_px(0, 512);
  // Each is brighter than 2 DN over 970 px: 15 % of the image, less where they overlap.
  for (int i = 0; i < 110; ++i) image.Add({x_px(random), y_px(random), 5, 1000});
  image.Expose({2, 1e9}, &random);
  const Background lit = EstimateBackground(image.View());
  // The median of a normal distribution with 15 % more above lies 0.22 sigma higher, its 16 % quantile 0.11
  // sigma.
  CHECK(lit.level_dn > dark.level_dn);
  CHECK(lit.level_dn < dark.level_dn + 0.35 * 2);
  CHECK(lit.noise_dn < 1.25 * dark.noise_dn);
}

TEST(Background, OfImagesSmallerThanOneStepIsReadInsideThem) {
  for (const int height_px : {1, 2, 15, 16, 17, 48}) {
    for (const int width_px : {1, 7, 8, 9}) {
      RenderedImage image(width_px, height_px);
      image.Background(33);
      image.Expose({}, nullptr);
      DOUBLES_EQUAL(33, EstimateBackground(image.View()).level_dn, 0.01);
    }
  }
}
