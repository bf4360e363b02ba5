#include "drivers/sim/renderer.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "drivers/sim/live_scene.h"
#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::base::Side;
using adit::sim::LiveScene;
using adit::sim::NoiseSource;
using adit::sim::Renderer;
using adit::sim::World;
using adit::tests::kBarKeys;
using adit::tests::kSmallRig;
using adit::tests::SceneOf;

namespace {

constexpr int kWidthPx = 320, kHeightPx = 240;

std::vector<std::uint8_t> Frame(Renderer& renderer, std::uint64_t trigger) {
  std::vector<std::uint8_t> pixels(renderer.FrameBytes());
  renderer.Render(trigger, pixels.data());
  return pixels;
}

std::vector<std::uint8_t> FrameOf(const std::string& text, std::uint64_t trigger, NoiseSource source) {
  const World world(SceneOf(text));
  Renderer renderer(world, Side::kLeft, source);
  return Frame(renderer, trigger);
}

struct Blob {
  double flux = 0, x_px = 0, y_px = 0;
};

/// Sum and centroid of the light within 10 px of a place.
Blob BlobAt(const std::vector<float>& light, double x_px, double y_px) {
  Blob blob;
  for (int y = 0; y < kHeightPx; ++y) {
    for (int x = 0; x < kWidthPx; ++x) {
      if (std::abs(x - x_px) > 10 || std::abs(y - y_px) > 10) continue;
      const double here = static_cast<double>(light[static_cast<std::size_t>(y * kWidthPx + x)]);
      blob.flux += here, blob.x_px += here * x, blob.y_px += here * y;
    }
  }
  blob.x_px /= blob.flux, blob.y_px /= blob.flux;
  return blob;
}

const std::string kDistortedRig =
    "rig: {base_m: 1, focal_px: 800, width_px: 320, height_px: 240, converge_m: 20,"
    " left: {distortion: [-0.1, 0.05, 0.001, -0.002], centre_px: [161.2, 118.7]},"
    " right: {distortion: [0.08, 0, -0.001, 0.001], roll_deg: 2, pitch_deg: -1}}\n";

}  // namespace

TEST_GROUP(Renderer){};

TEST(Renderer, PutsEachLedWhereOpenCvProjectsItsTruth) {
  const World world(SceneOf(kDistortedRig +
                            "targets: [{name: b, leds_m: [0, 0.6, 1.3, 3], led_diameter_m: 0.03, "
                            "at_m: [-1.6, -0.7, 19], direction: [0.9, 0.3, 0.2]}]\n"));
  const auto truth = world.TruthAt(0).front();
  const auto& rig = world.GetScene().rig;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    Renderer renderer(world, side, NoiseSource::kFresh);
    const auto light = renderer.Light(0);
    const auto& c = world.Camera(side);
    const cv::Matx33d k(c.fu_px, 0, c.cu_px, 0, c.fv_px, c.cv_px, 0, 0, 1);
    for (const Eigen::Vector3d& led_m : truth.leds_m) {
      const Eigen::Vector3d p = side == Side::kLeft ? led_m : rig.T_r_l * led_m;
      std::vector<cv::Point2d> px;
      cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(), k,
                        std::vector<double>{c.k1, c.k2, c.p1, c.p2}, px);
      const Blob blob = BlobAt(light, px[0].x, px[0].y);
      DOUBLES_EQUAL(px[0].x, blob.x_px, 1e-3);
      DOUBLES_EQUAL(px[0].y, blob.y_px, 1e-3);
    }
  }
}

TEST(Renderer, LosesLightWithTheSquareOfTheDistance) {
  const auto flux_at = [](double z_m) {
    const World world(SceneOf(kSmallRig + "lamps: [{diameter_m: 0.02, surface_dn: 500, at_m: [0, 0, " +
                              std::to_string(z_m) + "]}]\n"));
    Renderer renderer(world, Side::kLeft, NoiseSource::kFresh);
    return BlobAt(renderer.Light(0), 159.5, 119.5).flux;
  };
  DOUBLES_EQUAL(4, flux_at(15) / flux_at(30), 0.01);
}

TEST(Renderer, BlursAMovingLedAboutTheMiddleOfTheExposure) {
  // 2 m/s across at 20 m: 80 px/s, 8 px in 0.1 s.
  const World world(
      SceneOf(kSmallRig +
              "rate_hz: 2\nexposure_s: 0.1\nlamps: [{diameter_m: 0.02, surface_dn: 900, "
              "path: {waypoints: [{t_s: 0, at_m: [-1, 0, 20]}, {t_s: 1, at_m: [1, 0, 20]}]}}]\n"));
  Renderer renderer(world, Side::kLeft, NoiseSource::kFresh);
  const auto light = renderer.Light(1);
  const double middle_px = 159.5 + 800 * (-1 + 2 * (0.5 + 0.05)) / 20;
  const Blob blob = BlobAt(light, middle_px, 119.5);
  DOUBLES_EQUAL(middle_px, blob.x_px, 5e-3);
  DOUBLES_EQUAL(119.5, blob.y_px, 1e-3);
  double spread = 0;
  for (int x = 0; x < kWidthPx; ++x)
    for (int y = 110; y < 130; ++y)
      spread +=
          static_cast<double>(light[static_cast<std::size_t>(y * kWidthPx + x)]) * std::pow(x - blob.x_px, 2);
  // PSF, the pixel, and a box of 8 px.
  DOUBLES_EQUAL(1.3 * 1.3 + 1.0 / 12 + 64.0 / 12, spread / blob.flux, 0.1);
}

TEST(Renderer, ShowsTheSameFrameWhateverWasRenderedBefore) {
  const std::string text =
      kSmallRig + "targets: [{" + kBarKeys + ", at_m: [0, 0, 20]}]\nlamps: [{at_m: [1, 1, 20]}]\n";
  for (const NoiseSource source : {NoiseSource::kFresh, NoiseSource::kBank}) {
    const World world(SceneOf(text));
    Renderer first(world, Side::kLeft, source), second(world, Side::kLeft, source);
    const auto wanted = Frame(first, 7);
    Frame(second, 3);
    CHECK_TRUE(wanted == Frame(second, 7));
    CHECK_TRUE(wanted == Frame(second, 7));
  }
}

TEST(Renderer, ShowsOtherNoiseForAnotherTriggerSideOrSeed) {
  for (const NoiseSource source : {NoiseSource::kFresh, NoiseSource::kBank}) {
    const World world(SceneOf(kSmallRig + "seed: 1\n")), other(SceneOf(kSmallRig + "seed: 2\n"));
    Renderer left(world, Side::kLeft, source), right(world, Side::kRight, source),
        seed(other, Side::kLeft, source);
    const auto frame = Frame(left, 7);
    CHECK_FALSE(frame == Frame(left, 8));
    CHECK_FALSE(frame == Frame(right, 7));
    CHECK_FALSE(frame == Frame(seed, 7));
  }
}

TEST(Renderer, HasTheNoiseOfItsModelInLitAndDarkPixels) {
  const std::string text = kSmallRig +
                           "lamps: [{at_m: [0, 0, 20], diameter_m: 1.5, surface_dn: 120}]\n"
                           "sensor: {background_dn: 20}\n";
  for (const NoiseSource source : {NoiseSource::kFresh, NoiseSource::kBank}) {
    const World world(SceneOf(text));
    Renderer renderer(world, Side::kLeft, source);
    double sums[2] = {0, 0}, squares[2] = {0, 0};
    constexpr int kFrames = 200, kSide = 20;
    for (std::uint64_t trigger = 0; trigger < kFrames; ++trigger) {
      const auto frame = Frame(renderer, trigger);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const double values[2] = {
              static_cast<double>(frame[static_cast<std::size_t>((110 + y) * kWidthPx + 150 + x)]),
              static_cast<double>(frame[static_cast<std::size_t>(y * kWidthPx + x)])};
          for (int i = 0; i < 2; ++i) sums[i] += values[i], squares[i] += values[i] * values[i];
        }
      }
    }
    constexpr double kCount = kFrames * kSide * kSide;
    const double light[2] = {120, 0};
    for (int i = 0; i < 2; ++i) {
      const double mean = sums[i] / kCount, variance = squares[i] / kCount - mean * mean;
      const double expected = 1.5 * 1.5 + 1.0 / 12 + light[i] / 40;
      DOUBLES_EQUAL(20 + light[i], mean, 5 * std::sqrt(expected / kCount) + 0.002 * light[i]);
      DOUBLES_EQUAL(expected, variance, 5 * expected * std::sqrt(2 / kCount));
    }
  }
}

TEST(Renderer, FillsTwoBytesAPixelFor12Bit) {
  const std::string text =
      kSmallRig + "sensor: {bits: 12}\nlamps: [{at_m: [0, 0, 20], surface_dn: 5000, diameter_m: 0.5}]\n";
  const auto frame = FrameOf(text, 0, NoiseSource::kFresh);
  LONGS_EQUAL(2 * kWidthPx * kHeightPx, frame.size());
  const auto* pixels = reinterpret_cast<const std::uint16_t*>(frame.data());
  LONGS_EQUAL(4095, pixels[119 * kWidthPx + 159]);
  CHECK_TRUE(pixels[0] > 0 && pixels[0] < 16 * 14);
}

TEST(Renderer, HidesHalfOfALightBehindAnEdge) {
  const std::string lamp = "lamps: [{at_m: [0, 0, 20], diameter_m: 0.5, surface_dn: 100}]\n";
  const World whole(SceneOf(kSmallRig + lamp));
  const World half(SceneOf(kSmallRig + lamp + "occluders: [{at_m: [1, 0, 10], width_m: 2, height_m: 4}]\n"));
  Renderer whole_renderer(whole, Side::kLeft, NoiseSource::kFresh),
      half_renderer(half, Side::kLeft, NoiseSource::kFresh);
  const Blob all = BlobAt(whole_renderer.Light(0), 159.5, 119.5),
             rest = BlobAt(half_renderer.Light(0), 159.5, 119.5);
  DOUBLES_EQUAL(0.5, rest.flux / all.flux, 0.05);
  // The centroid of half a disc of 10 px lies 4 / (3 pi) of the radius from its middle.
  DOUBLES_EQUAL(159.5 - 4.244, rest.x_px, 0.3);
}

TEST(Renderer, AddsGlareAndTheGlowOfFogRoundALight) {
  const std::string lamp = "lamps: [{at_m: [0, 0, 20], diameter_m: 0.2, surface_dn: 3000}]\n";
  const auto beside = [](const std::string& text) {
    const World world(SceneOf(text));
    Renderer renderer(world, Side::kLeft, NoiseSource::kFresh);
    return renderer.Light(0)[119 * kWidthPx + 159 + 25];
  };
  DOUBLES_EQUAL(0, beside(kSmallRig + lamp), 0);
  CHECK_TRUE(beside(kSmallRig + lamp + "sensor: {glare: 0.05, glare_sigma_px: 15}\n") > 1);
  CHECK_TRUE(beside(kSmallRig + lamp + "fog: {per_m: 0.02, glow: 0.5, glow_sigma_px: 20}\n") > 1);
}

TEST(Renderer, StaysDarkForLightsBehindBesideOrTooFaint) {
  // Behind, beside, and a spark: none may change a dark frame.
  const std::string dark = kSmallRig;
  const std::string lamps = kSmallRig +
                            "lamps: [{at_m: [0, 0, -20]}, {at_m: [500, 0, 20]}, "
                            "{at_m: [0, 0, 900], diameter_m: 0.001, surface_dn: 1}]\n";
  CHECK_TRUE(FrameOf(dark, 4, NoiseSource::kFresh) == FrameOf(lamps, 4, NoiseSource::kFresh));
}

TEST_GROUP(LiveScene){};

TEST(LiveScene, RendersBothSidesAndKnowsTheTruth) {
  LiveScene scene(SceneOf(kSmallRig + "targets: [{" + kBarKeys + ", at_m: [0, 0, 20]}]\n"),
                  NoiseSource::kBank);
  std::vector<std::uint8_t> left(scene.FrameBytes(Side::kLeft)), right(scene.FrameBytes(Side::kRight));
  scene.Render(Side::kLeft, 5, left.data());
  scene.Render(Side::kRight, 5, right.data());
  CHECK_FALSE(left == right);
  LONGS_EQUAL(kWidthPx, scene.WidthPx(Side::kRight));
  LONGS_EQUAL(kHeightPx, scene.HeightPx(Side::kRight));
  LONGS_EQUAL(8, scene.Bits());
  const auto rows = scene.Truth(5);
  LONGS_EQUAL(1, rows.size());
  LONGS_EQUAL(5, rows[0].trigger);
  LONGS_EQUAL(4, rows[0].visible);
}

TEST(LiveScene, DeclinesASceneThatIsNotThere) {
  CHECK_FALSE(static_cast<bool>(LiveScene::Open("/nonexistent/scene.yaml", NoiseSource::kBank)));
}
