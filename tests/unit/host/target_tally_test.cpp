#include "host/target_tally.h"

#include <memory>

#include "host/tunnel.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CountEpisode;
using adit::host::Episode;
using adit::host::Imaging;
using adit::host::ModelsOf;
using adit::host::TargetTally;
using adit::host::Tunnel;
using adit::host::TunnelRig;
using adit::host::TunnelTargets;

constexpr std::size_t kFrames = 30;

/// One target at 30 m with bright LEDs, hidden or not.
Tunnel OneTarget(std::uint64_t seed) {
  Tunnel tunnel(seed, TunnelRig(9));
  tunnel.AddTarget(TunnelTargets()[0], {30, 30, 2});
  return tunnel;
}

TargetTally Counted(Tunnel& tunnel, Imaging imaging, std::size_t frames = kFrames) {
  Episode episode(tunnel.Take(), ModelsOf({TunnelTargets()[0]}), imaging);
  return CountEpisode(episode, frames, "test");
}

}  // namespace

TEST_GROUP(TargetTally){};

TEST(TargetTally, ATargetInTheClearIsFoundInCentroidsAndInImages) {
  for (const Imaging imaging : {Imaging::kCentroids, Imaging::kRendered}) {
    Tunnel tunnel = OneTarget(11);
    const std::size_t frames = imaging == Imaging::kRendered ? 3 : kFrames;
    const TargetTally tally = Counted(tunnel, imaging, frames);
    LONGS_EQUAL(frames, tally.target_frames);
    LONGS_EQUAL(frames, tally.four.frames);
    LONGS_EQUAL(frames, tally.four.found);
    LONGS_EQUAL(0, tally.swapped + tally.off_tracked + tally.off_recovered);
  }
}

TEST(TargetTally, AHiddenLedIsHiddenFromThatCamera) {
  for (const int side : {0, 1, 2}) {
    Tunnel tunnel = OneTarget(12);
    tunnel.Hide(0, 2, side, {});
    const TargetTally tally = Counted(tunnel, Imaging::kCentroids);
    LONGS_EQUAL(kFrames, tally.three.frames);
    LONGS_EQUAL(0, tally.off_tracked);
  }
}

TEST(TargetTally, CountsWhatIsWrongInRenderedImages) {
  for (const Imaging imaging : {Imaging::kCentroids, Imaging::kRendered}) {
    Tunnel tunnel = OneTarget(12);
    Episode episode(tunnel.Take(), ModelsOf({TunnelTargets()[0]}), imaging);
    const auto result = std::make_unique<adit::pipeline::PairResult>(episode.Expose(0));
    result->fixes.targets[0].state.points.epicenter_b_m.x() += 1;
    adit::host::TargetCounter counter(episode, "test");
    counter.Count(0, *result);
    const TargetTally tally = counter.Take();
    LONGS_EQUAL(1, tally.off_tracked);
    LONGS_EQUAL(imaging == Imaging::kRendered ? 1 : 0, tally.wrong_rendered);
  }
}

TEST(TargetTally, TheSameSeedGivesTheSameCounts) {
  Tunnel first = OneTarget(13), second = OneTarget(13);
  first.AddLamps(50), second.AddLamps(50);
  first.AddCollinear(0, 4), second.AddCollinear(0, 4);
  const TargetTally a = Counted(first, Imaging::kCentroids), b = Counted(second, Imaging::kCentroids);
  LONGS_EQUAL(a.four.frames, b.four.frames);
  LONGS_EQUAL(a.any.found, b.any.found);
}

TEST(TargetTally, CollinearLightsStandOnTheBarsLineInTheLeftImage) {
  Tunnel tunnel = OneTarget(14);
  tunnel.AddCollinear(0, 6);
  const adit::sim::World world(tunnel.Take());
  const auto px = [&world](std::size_t light) {
    const auto seen = world.Receive(light, adit::base::Side::kLeft, 0.5);
    return Eigen::Vector2d(seen->disc.x_px, seen->disc.y_px);
  };
  const Eigen::Vector2d first = px(0), along = (px(3) - px(0)).normalized();
  std::size_t seen = 0;
  for (std::size_t light = 4; light < world.LightCount(); ++light) {
    if (!world.Receive(light, adit::base::Side::kLeft, 0.5)) continue;
    ++seen;
    const Eigen::Vector2d off = px(light) - first;
    CHECK(std::abs(off.x() * along.y() - off.y() * along.x()) < 1);  // the lens bends the line
  }
  CHECK(seen >= 3);
}
