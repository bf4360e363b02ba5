#include "drivers/sim/spot.h"

#include <cmath>
#include <numbers>

#include <CppUTest/TestHarness.h>

using adit::sim::AddHalo;
using adit::sim::Canvas;
using adit::sim::Disc;
using adit::sim::PixelBox;
using adit::sim::SpotPainter;

namespace {

constexpr double kSigmaPx = 1.3;
const PixelBox kBox{0, 0, 80, 70};

struct Moments {
  double flux = 0, x = 0, y = 0;
};

Moments MomentsOf(const Canvas& canvas) {
  Moments m;
  for (int y = kBox.y0; y < kBox.y1; ++y) {
    for (int x = kBox.x0; x < kBox.x1; ++x) {
      m.flux += canvas.At(x, y);
      m.x += x * static_cast<double>(canvas.At(x, y));
      m.y += y * static_cast<double>(canvas.At(x, y));
    }
  }
  m.x /= m.flux, m.y /= m.flux;
  return m;
}

/// Light of a point source in one pixel, exactly.
double PointInPixel(double x, double y) {
  const auto share = [](double d) {
    const double scale = kSigmaPx * std::numbers::sqrt2;
    return 0.5 * (std::erf((d + 0.5) / scale) - std::erf((d - 0.5) / scale));
  };
  return share(x) * share(y);
}

/// Light of a disc in the pixel at (x, y) from its centre: many points, each exact.
double DiscInPixel(double radius_px, double x, double y) {
  constexpr int kRings = 150, kSpokes = 60;
  double sum = 0;
  for (int r = 0; r < kRings; ++r) {
    const double at = radius_px * std::sqrt((r + 0.5) / kRings);  // rings of equal area
    for (int s = 0; s < kSpokes; ++s) {
      const double angle = 2 * std::numbers::pi * (s + 0.5) / kSpokes;
      sum += PointInPixel(x - at * std::cos(angle), y - at * std::sin(angle));
    }
  }
  return sum / (kRings * kSpokes);
}

}  // namespace

TEST_GROUP(Spot) { const SpotPainter painter{kSigmaPx}; };

TEST(Spot, OfAPointIsTheGaussianIntegratedOverThePixels) {
  Canvas canvas(kBox);
  painter.Add({30.3, 25.8, 0, 1000}, canvas);
  const double peak = 1000 * PointInPixel(0, 0);
  for (int y = 18; y < 34; ++y)
    for (int x = 22; x < 38; ++x)
      DOUBLES_EQUAL(1000 * PointInPixel(x - 30.3, y - 25.8), canvas.At(x, y), 1e-3 * peak);
}

TEST(Spot, OfADiscIsItsConvolution) {
  for (const double radius_px : {0.5, 1.0, 2.25, 4.0, 7.0}) {  // multiples of the table's step
    Canvas canvas(kBox);
    painter.Add({30.4, 25.1, radius_px, 1000}, canvas);
    const double peak = 1000 * DiscInPixel(radius_px, 0, 0);
    for (int y = 16; y < 36; y += 5)
      for (int x = 20; x < 42; x += 2)
        DOUBLES_EQUAL(1000 * DiscInPixel(radius_px, x - 30.4, y - 25.1), canvas.At(x, y), 2e-3 * peak);
  }
}

TEST(Spot, HasItsFluxAndItsCentroidWhateverRadiusAndPhase) {
  for (const double radius_px : {0.0, 0.33, 1.111, 2.017, 5.3, 7.79, 7.81, 12.4}) {
    for (int phase = 0; phase < 10; ++phase) {
      const double x = 35 + 0.1 * phase, y = 30 + 0.37 * phase;
      Canvas canvas(kBox);
      painter.Add({x, y, radius_px, 500}, canvas);
      const Moments m = MomentsOf(canvas);
      DOUBLES_EQUAL(500, m.flux, 1.0);  // 0.2 %
      DOUBLES_EQUAL(x, m.x, 2e-3);
      DOUBLES_EQUAL(y, m.y, 2e-3);
    }
  }
}

TEST(Spot, OfAnLedHasItsCentroidToAThousandthOfAPixel) {
  // What the best estimator could find in one image is 0.003 px: the picture must be truer than that.
  for (int phase = 0; phase < 20; ++phase) {
    const double x = 35 + 0.05 * phase, y = 30 + 0.19 * phase;
    Canvas canvas(kBox);
    painter.Add({x, y, 1.7, 3000}, canvas);
    const Moments m = MomentsOf(canvas);
    DOUBLES_EQUAL(x, m.x, 2e-4);
    DOUBLES_EQUAL(y, m.y, 2e-4);
  }
}

TEST(Spot, IsAsBrightAsItsDiscWhenItIsLarge) {
  for (const double radius_px : {7.5, 15.0}) {
    const double surface_dn = 40;
    const Disc disc{40, 35, radius_px, surface_dn * std::numbers::pi * radius_px * radius_px};
    DOUBLES_EQUAL(surface_dn, painter.Value(disc, 0), 0.01 * surface_dn);
    DOUBLES_EQUAL(surface_dn / 2, painter.Value(disc, radius_px), 0.05 * surface_dn);
  }
}

TEST(Spot, EndsWhereItsProfileFallsBelowTheLevel) {
  // A point of peak 200 DN falls to 12 DN at sigma sqrt(2 ln(200 / 12)) = 2.3720 sigma.
  const Disc point{0, 0, 0, 200 * 2 * std::numbers::pi * kSigmaPx * kSigmaPx};
  DOUBLES_EQUAL(2.3720 * kSigmaPx, painter.ExtentPx(point, 12), 2e-3);
  DOUBLES_EQUAL(0, painter.ExtentPx(point, 201), 0);
}

TEST(Spot, IsCutAtTheBorderOfTheCanvas) {
  Canvas canvas(kBox);
  painter.Add({0, 35, 1, 1000}, canvas);
  painter.Add({-50, 35, 1, 1000}, canvas);
  painter.Add({1e9, -1e9, 1, 1000}, canvas);
  // Half of it and half of the middle column, whose share is erf(0.5 / (sqrt 2 sigma)), sigma^2 = 1.3^2 +
  // 1/4.
  DOUBLES_EQUAL(500 + 0.5 * 1000 * 0.2803, MomentsOf(canvas).flux, 1);
}

TEST(Spot, MarksTheTilesThatItLights) {
  Canvas canvas(kBox);
  painter.Add({70, 60, 1, 1000}, canvas);
  CHECK_TRUE(canvas.Marked(1, 3));
  CHECK_FALSE(canvas.Marked(0, 0));
  canvas.Clear();
  CHECK_FALSE(canvas.Marked(1, 3));
  DOUBLES_EQUAL(0, canvas.At(70, 60), 0);
}

TEST(Spot, HasAHaloThatIsAWideGaussian) {
  Canvas canvas(kBox);
  AddHalo({40.2, 35.1, 2, 5000}, 6, canvas);
  const Moments m = MomentsOf(canvas);
  DOUBLES_EQUAL(5000, m.flux, 25);
  DOUBLES_EQUAL(40.2, m.x, 0.05);
  DOUBLES_EQUAL(5000 / (2 * std::numbers::pi * 36) * std::exp(-0.5 * (0.04 + 0.01) / 36), canvas.At(40, 35),
                1e-3);
}

TEST_GROUP(Canvas){};

TEST(Canvas, AddsAnotherWhereTheyOverlap) {
  Canvas canvas(kBox);
  Canvas part({70, 60, 100, 90});
  for (int y = 60; y < 90; ++y)
    for (int x = 70; x < 100; ++x) part.At(x, y) = static_cast<float>(x);
  canvas.Add(part, 2);
  DOUBLES_EQUAL(2 * 79, canvas.At(79, 69), 0);
  DOUBLES_EQUAL(0, canvas.At(69, 69), 0);
  CHECK_TRUE(canvas.Marked(1, 4));
}
