#include "host/simulated_blobs.h"

#include <Eigen/LU>
#include <cmath>
#include <memory>

#include "host/tunnel.h"
#include "tests/support/small_scene.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::Side;
using adit::detect::BlobSet;
using adit::host::SimulatedBlobs;
using adit::sim::World;
using Eigen::Matrix2d;
using Eigen::Vector2d;

std::unique_ptr<BlobSet> Exposed(SimulatedBlobs& simulated, Side side, std::uint64_t trigger) {
  auto blobs = std::make_unique<BlobSet>();
  simulated.Expose(side, trigger, *blobs);
  return blobs;
}

/// Two lamps level with each other, 20 m away, about `apart_px` apart.
adit::sim::Scene TwoLamps(double apart_px) {
  const std::string looks = ", 0, 20], diameter_m: 0.024, surface_dn: 900}";
  const double second_m = 0.5 + apart_px * 20 / 800;
  return adit::tests::SceneOf(adit::tests::kSmallRig + "lamps: [{at_m: [0.5" + looks + ", {at_m: [" +
                              std::to_string(second_m) + looks + "]\n");
}

}  // namespace

TEST_GROUP(SimulatedBlobs){};

TEST(SimulatedBlobs, StandWhereTheCameraReceivesTheLights) {
  adit::host::Tunnel tunnel(3, adit::host::TunnelRig(9));
  for (const auto& target : adit::host::TunnelTargets()) tunnel.AddTarget(target, {20, 50});
  const World world(tunnel.Take());
  SimulatedBlobs simulated(world, 1e-6);
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto blobs = Exposed(simulated, side, 0);
    LONGS_EQUAL(12, blobs->blobs.size());
    for (std::size_t light = 0; light < 12; ++light) {
      const auto seen = world.Receive(light, side, world.MidExposureS(0));
      double nearest_px = 1e9;
      for (const auto& blob : blobs->blobs)
        nearest_px = std::min(nearest_px, (blob.raw_px - Vector2d(seen->disc.x_px, seen->disc.y_px)).norm());
      CHECK(nearest_px < 1e-4);
    }
  }
}

TEST(SimulatedBlobs, TakeTheLensOutAsItWasPutIn) {
  const auto rig = adit::support::ToedInRig();
  const auto camera = rig.AsRig().left;
  for (const Vector2d& ideal_px :
       {Vector2d(20, 30), Vector2d(700, 500), Vector2d(1380, 1000), Vector2d(300, 900)}) {
    Matrix2d slope;
    const Vector2d raw_px = rig.left.Distorted(ideal_px);
    const Vector2d back_px = adit::host::IdealPx(camera, raw_px, slope);
    CHECK((back_px - ideal_px).norm() < 1e-8);
    const Vector2d step(0.3, -0.2);
    Matrix2d unused;
    const Vector2d moved_px = adit::host::IdealPx(camera, raw_px + step, unused);
    CHECK((moved_px - back_px - slope * step).norm() < 1e-4);
  }
}

TEST(SimulatedBlobs, ScatterAsTheirCovarianceSays) {
  const World world(TwoLamps(30));
  SimulatedBlobs simulated(world);
  double nees = 0;
  int count = 0;
  const auto first = world.Receive(0, Side::kLeft, 0), second = world.Receive(1, Side::kLeft, 0);
  for (std::uint64_t trigger = 0; trigger < 500; ++trigger) {
    const auto blobs = Exposed(simulated, Side::kLeft, trigger);
    LONGS_EQUAL(2, blobs->blobs.size());
    for (const auto& blob : blobs->blobs) {
      const bool is_first = std::abs(blob.raw_px.x() - first->disc.x_px) < 5;
      const auto& disc = is_first ? first->disc : second->disc;
      const Vector2d error_px = blob.ideal_px - Vector2d(disc.x_px, disc.y_px);  // no distortion in this rig
      nees += error_px.dot(blob.covariance_px2.inverse() * error_px), ++count;
    }
  }
  DOUBLES_EQUAL(2, nees / count, 0.25);  // four standard errors of 1000 draws of 2 degrees of freedom
}

TEST(SimulatedBlobs, NeighboursRunTogetherAtTheirCommonMiddle) {
  const World near(TwoLamps(4)), apart(TwoLamps(14));
  SimulatedBlobs near_blobs(near, 1e-6), apart_blobs(apart, 1e-6);
  const auto joined = Exposed(near_blobs, Side::kLeft, 0);
  LONGS_EQUAL(1, joined->blobs.size());
  const auto first = near.Receive(0, Side::kLeft, 0), second = near.Receive(1, Side::kLeft, 0);
  DOUBLES_EQUAL((first->disc.x_px + second->disc.x_px) / 2, joined->blobs[0].raw_px.x(), 1e-3);
  CHECK(joined->blobs[0].sigma_major_px > 1.5F * joined->blobs[0].sigma_minor_px);
  for (const auto& disc : {first->disc, second->disc})
    CHECK(joined->blobs[0].x_min_px < disc.x_px - 1 && joined->blobs[0].x_max_px > disc.x_px + 1);
  LONGS_EQUAL(2, Exposed(apart_blobs, Side::kLeft, 0)->blobs.size());
}

TEST(SimulatedBlobs, DependOnNothingButSceneSideAndTrigger) {
  const World world(TwoLamps(30));
  SimulatedBlobs a(world), b(world);
  Exposed(a, Side::kRight, 3);
  const auto one = Exposed(a, Side::kLeft, 7), other = Exposed(b, Side::kLeft, 7);
  CHECK(one->blobs[0].raw_px == other->blobs[0].raw_px);
  CHECK(one->blobs[0].raw_px != Exposed(b, Side::kLeft, 8)->blobs[0].raw_px);
}

TEST(SimulatedBlobs, NoiseFollowsTheBound) {
  DOUBLES_EQUAL(0.0277, adit::host::CentroidNoisePx(50), 1e-9);
  DOUBLES_EQUAL(0.0084, adit::host::CentroidNoisePx(200), 1e-9);
  CHECK(adit::host::CentroidNoisePx(100) > adit::host::CentroidNoisePx(101));
  DOUBLES_EQUAL(0.0053, adit::host::CentroidNoisePx(5000), 1e-9);
}
