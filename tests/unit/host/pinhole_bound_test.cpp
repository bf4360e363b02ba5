#include "host/pinhole_bound.h"

#include <cmath>

#include "host/simulated_blobs.h"
#include "host/tunnel.h"

#include <CppUTest/TestHarness.h>

namespace {

adit::sim::Scene EmptyTunnel() { return adit::host::Tunnel(1, adit::host::TunnelRig(9)).Take(); }

/// A small disc that peaks at `peak_dn`.
adit::sim::Disc DiscOf(const adit::sim::World& world, double peak_dn) {
  adit::sim::Disc disc{700.3, 500.6, 1.0, 1};
  disc.flux_dn = peak_dn / world.Painter().Value(disc, 0);
  return disc;
}

}  // namespace

TEST_GROUP(PinholeBound){};

TEST(PinholeBound, AgreesWithTheTableOfTheSimulatedCentroids) {
  // The table was computed apart (Gaussian spots of sigma 1.5 px): it holds for this spot of 1.4 px too.
  const adit::sim::World world(EmptyTunnel());
  for (const double peak_dn : {50.0, 100.0, 200.0}) {
    const double bound_px = adit::host::DiscBoundPx(world, DiscOf(world, peak_dn));
    DOUBLES_EQUAL(1, bound_px / adit::host::CentroidNoisePx(peak_dn), 0.08);
  }
}

TEST(PinholeBound, ClippedPixelsTellNothing) {
  const adit::sim::World world(EmptyTunnel());
  const double whole_px = adit::host::DiscBoundPx(world, DiscOf(world, 240));
  const double clipped_px = adit::host::DiscBoundPx(world, DiscOf(world, 400));
  CHECK(clipped_px < whole_px);                // the flanks are brighter
  CHECK(clipped_px > whole_px * 240.0 / 400);  // but the middle is lost
}

TEST(PinholeBound, DepthIsThatOfTwoRaysThatCross) {
  // 50 m before the middle of a base of 9 m: a step in depth turns each ray by sin(half) / way.
  constexpr double kNoisePx = 0.05, kHalfBaseM = 4.5, kAheadM = 50, kFocalPx = 3378;
  const adit::sim::World world(EmptyTunnel());
  const double toe_rad = std::atan(kHalfBaseM / 35);
  const Eigen::Vector3d across(std::cos(toe_rad), 0, std::sin(toe_rad)),
      ahead(-std::sin(toe_rad), 0, std::cos(toe_rad));
  const Eigen::Vector3d point_m = kHalfBaseM * across + kAheadM * ahead;
  const Eigen::Matrix3d bound_m2 = adit::host::PointBoundM2(world, point_m, {kNoisePx, kNoisePx});
  const double way_m = std::hypot(kHalfBaseM, kAheadM);
  const double expected_m = kNoisePx / kFocalPx * way_m / (std::sqrt(2.0) * kHalfBaseM / way_m);
  DOUBLES_EQUAL(1, std::sqrt(ahead.dot(bound_m2 * ahead)) / expected_m, 0.01);
}
