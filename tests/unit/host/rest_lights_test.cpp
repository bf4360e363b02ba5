#include "host/rest_lights.h"

#include <Eigen/LU>
#include <cmath>

#include "host/calibration.h"
#include "host/simulated_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::host::CalibrationDraw;
using adit::host::Gauss;
using adit::host::LedView;
using adit::host::Locate;
using adit::host::RestFinder;
using adit::host::RestLights;
using adit::host::TrueRig;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector2d kPlacePx(1300.3, 80.7);
constexpr double kLightNoisePx = 0.03;

adit::optics::CameraModel RestingCamera() { return adit::host::MakeTrueRig(9, 35).AsRig().left; }

Blob BlobAt(const Vector2d& raw_px) {
  Blob blob;
  blob.raw_px = raw_px;
  blob.covariance_px2 = kLightNoisePx * kLightNoisePx * Eigen::Matrix2d::Identity();
  return blob;
}

Vector2d Noise(adit::sim::Random& random) { return kLightNoisePx * Vector2d(Gauss(random), Gauss(random)); }

/// An LED of `rig` as both cameras measured it over many frames.
std::pair<LedView, LedView> AtRest(const CalibrationDraw& draw, const Vector3d& place_m,
                                   adit::sim::Random& random) {
  constexpr double kSigmaPx = 0.01;
  Eigen::Vector4d px = draw.rig.Project(place_m);
  for (double& value : px) value += kSigmaPx * Gauss(random);
  const auto view = [](const Vector2d& raw_px, const adit::optics::CameraModel& camera) {
    return LedView{raw_px, *camera.Undistort(raw_px), kSigmaPx * kSigmaPx * Eigen::Matrix2d::Identity()};
  };
  return {view(px.head<2>(), draw.input.left), view(px.tail<2>(), draw.input.right)};
}

/// Lights anywhere near the left image's corners, from 20 to 60 m, that the right camera sees too.
RestLights InTheCorners(const CalibrationDraw& draw, std::size_t count, adit::sim::Random& random) {
  RestLights lights;
  while (lights.left.size() < count) {
    const double z_m = random.Uniform(20, 60);
    const auto ray = [&](double half) {
      return std::copysign(random.Uniform(0.7, 0.98), Gauss(random)) * half;
    };
    const Vector3d place_m(z_m * ray(700.0 / 3378), z_m * ray(512.0 / 3378), z_m);
    const Eigen::Vector4d px = draw.rig.Project(place_m);
    const Vector2d right_px = px.tail<2>();
    if (right_px.x() < 5 || right_px.y() < 5 || right_px.x() > 1394 || right_px.y() > 1018) continue;
    const auto [left, right] = AtRest(draw, place_m, random);
    lights.left.push_back(left), lights.right.push_back(right);
  }
  return lights;
}

/// Bars waved in the middle of both images alone, cameras wrong by their priors.
CalibrationDraw InTheMiddle(std::uint64_t seed) {
  adit::host::CalibrationPlan plan;
  plan.bars = 700;
  plan.noise_px = 0.03;
  CalibrationDraw draw = Draw(plan, seed);
  std::erase_if(draw.input.bars, [](const adit::host::StereoBar& bar) {
    const auto is_outside = [](const LedView& led) {
      return std::abs(led.raw_px.x() - 700) > 350 || std::abs(led.raw_px.y() - 512) > 256;
    };
    return std::any_of(bar.left.begin(), bar.left.end(), is_outside) ||
           std::any_of(bar.right.begin(), bar.right.end(), is_outside);
  });
  return draw;
}

/// Squared errors of places that show near the corners, and what the calibration states of them.
struct CornerErrors {
  double error_m2 = 0, stated_m2 = 0;

  void Add(const CalibrationDraw& draw, const adit::host::Calibration& calibration) {
    for (const double u : {-0.2, 0.2}) {
      for (const double v : {-0.14, 0.14}) {
        const Vector3d place_m = 35 * Vector3d(u, v, 1);
        const Eigen::Vector4d px = draw.rig.Project(place_m);
        const adit::host::RawPair pair{px.head<2>(), px.tail<2>()};
        const auto located_m = Locate(calibration.rig, pair);
        const auto derivatives = DerivativesOf(calibration.rig, pair);
        CHECK(located_m && derivatives);
        error_m2 += (*located_m - place_m).squaredNorm();
        stated_m2 += (derivatives->by_rig * calibration.covariance * derivatives->by_rig.transpose()).trace();
      }
    }
  }
};

}  // namespace

TEST_GROUP(RestLights) {
  adit::sim::Random random_{7};
  RestFinder finder_;
  BlobSet blobs_;

  void Add(std::initializer_list<Vector2d> places_px) {
    blobs_.blobs.clear();
    for (const Vector2d& px : places_px) blobs_.blobs.push_back(BlobAt(px));
    finder_.Add(blobs_);
  }
};

TEST(RestLights, OneThatStaysIsFoundAtItsMean) {
  for (int i = 0; i < 100; ++i) Add({kPlacePx + Noise(random_), {20.0 + 8 * i, 500}});
  const auto lights = finder_.Lights(RestingCamera());
  LONGS_EQUAL(1, lights.size());
  const double sigma_px = std::sqrt(kLightNoisePx * kLightNoisePx / 100 + 0.01 * 0.01);
  DOUBLES_EQUAL(0, (lights[0].raw_px - kPlacePx).norm(), 3 * kLightNoisePx / 10);
  DOUBLES_EQUAL(sigma_px, std::sqrt(lights[0].covariance_px2(0, 0)), 0.2 * sigma_px);
  DOUBLES_EQUAL(0, (lights[0].ideal_px - *RestingCamera().Undistort(lights[0].raw_px)).norm(), 1e-9);
}

TEST(RestLights, WhatWandersOrIsSeldomSeenIsNone) {
  for (int i = 0; i < 100; ++i) {
    Add({kPlacePx + Vector2d(0.02 * i, 0),
         Vector2d(300, 300) + (i % 5 == 0 ? 0.0 : 1.0) * Vector2d(3.0 * i, 0),
         Vector2d(700, 600) + 0.2 * Vector2d(Gauss(random_), Gauss(random_))});
  }
  LONGS_EQUAL(0, finder_.Lights(RestingCamera()).size());
}

TEST(RestLights, AFewFramesAreNotEnough) {
  for (int i = 0; i < 19; ++i) Add({kPlacePx});
  LONGS_EQUAL(0, finder_.Lights(RestingCamera()).size());
  Add({kPlacePx});
  LONGS_EQUAL(1, finder_.Lights(RestingCamera()).size());
}

// A bar's LED that passes takes the light's place in the image for a while.
TEST(RestLights, ABarThatPassesMovesNoLight) {
  for (int i = 0; i < 100; ++i) {
    if (i < 40 || i > 60)
      Add({kPlacePx + Noise(random_)});
    else
      Add({kPlacePx + Vector2d(i - 50.0, 0.6)});
  }
  const auto lights = finder_.Lights(RestingCamera());
  LONGS_EQUAL(1, lights.size());
  DOUBLES_EQUAL(0, (lights[0].raw_px - kPlacePx).norm(), 0.02);
}

TEST(RestLights, ThoseOfBothCamerasArePairedUnlessTwoMayBe) {
  adit::host::CalibrationPlan plan;
  plan.bars = 1;
  plan.intrinsics = {0, 0, 0};
  const CalibrationDraw draw = Draw(plan, 3);
  RestLights lights;
  // Far apart across the epipolar lines, but for the last two: at one height, 30 and 40 m away.
  for (const Vector3d& place_m : {Vector3d(2, -3, 30), Vector3d(1, 0, 30), Vector3d(1, 3, 30),
                                  Vector3d(2, 2, 30), Vector3d(8.0 / 3, 8.0 / 3, 40)}) {
    const auto [left, right] = AtRest(draw, place_m, random_);
    lights.left.push_back(left), lights.right.push_back(right);
  }
  lights.left.push_back(lights.left[0]);  // seen by one camera alone, on no other's line
  lights.left.back().ideal_px += Vector2d(0, 40);
  std::swap(lights.right[0], lights.right[2]);
  const auto points = MatchLights(lights, draw.rig.AsRig(), 1);
  LONGS_EQUAL(3, points.size());
  for (const auto& point : points) {
    const auto place_m = Locate(draw.rig.AsRig(), {point.left.raw_px, point.right.raw_px});
    CHECK(place_m.has_value());
    DOUBLES_EQUAL(30, place_m->z(), 0.05);
  }
}

// A light adds one equation (4 coordinates, 3 unknowns), a bar eleven.
TEST(RestLights, HelpTheCornersThatABarDoesNotReach) {
  CornerErrors without, with;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    CalibrationDraw draw = InTheMiddle(seed);
    const auto bars_alone = Calibrate(draw.input);
    adit::sim::Random random(seed, 2);
    draw.input.lights.push_back(InTheCorners(draw, 16, random));
    const auto lit = Calibrate(draw.input);
    CHECK_TRUE(bars_alone);
    CHECK_TRUE(lit);
    CHECK_COMPARE(lit->quality.points_used, >=, 12);
    without.Add(draw, *bars_alone);
    with.Add(draw, *lit);
  }
  CHECK_COMPARE(with.error_m2, <, 0.8 * without.error_m2);
  CHECK_COMPARE(with.stated_m2, <, 0.8 * without.stated_m2);
}

// A lamp that looks to each camera like another place than it is must not pull the rig.
TEST(RestLights, OneThatFitsNoRigIsLeftOut) {
  CalibrationDraw draw = InTheMiddle(20);
  RestLights lights = InTheCorners(draw, 16, random_);
  lights.right[3].raw_px.y() += 0.6, lights.right[3].ideal_px.y() += 0.6;
  draw.input.lights.push_back(lights);
  const auto calibration = Calibrate(draw.input);
  CHECK_TRUE(calibration);
  CHECK_COMPARE(calibration->quality.points_used, <=, 15);
  CHECK_COMPARE(calibration->quality.points_used, >=, 11);
}
