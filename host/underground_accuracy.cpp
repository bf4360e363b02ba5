// The cases that ask whether positions are as good as they can be, and as good as they say.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "host/crew.h"
#include "host/pinhole_bound.h"
#include "host/spread.h"
#include "host/target_tally.h"
#include "host/tunnel.h"
#include "host/underground_cases.h"

namespace adit::host {
namespace {

using base::Side;
using Eigen::Vector3d;

const char* HowImaged(Imaging imaging) { return imaging == Imaging::kRendered ? "rendered" : "centroids"; }

/// One target at a distance; LED `hidden` (0 to 3) is hidden from `side` (2: from both).
struct PlacedTarget {
  base::Target target;
  double distance_m;
  double speed_mps = 0;
  int hidden = -1, side = 2;
};

sim::Scene PlacedScene(std::uint64_t seed, const PlacedTarget& placed) {
  Tunnel tunnel(seed, TunnelRig(9));
  Tunnel::Ride ride;
  ride.nearest_m = ride.farthest_m = placed.distance_m;
  ride.speed_max_mps = placed.speed_mps;
  ride.peak_min_dn = placed.speed_mps > 0 ? 60 : 200;
  tunnel.AddTarget(placed.target, ride);
  if (placed.hidden >= 0) tunnel.Hide(0, static_cast<std::size_t>(placed.hidden), placed.side, {});
  return tunnel.Take();
}

/// Positions inside their stated ellipsoids, by status (tracked, recovered) and imaging.
struct EllipsoidTally {
  std::array<std::array<std::size_t, 2>, 2> positions{}, inside{};
};

constexpr double kChi95 = 7.815;  // chi-square, 3 degrees of freedom, 95 %
constexpr std::size_t kEllipsoidFrames = 40;

EllipsoidTally CountEllipsoids(std::uint64_t seed, double distance_m, std::size_t piece) {
  sim::Random draw(seed, 0x656c6c);
  PlacedTarget placed{TunnelTargets()[draw.Next() % 2], distance_m, 2};
  const bool recovered = piece % 2 == 1;
  if (recovered)
    placed.hidden = static_cast<int>(draw.Next() % 4), placed.side = static_cast<int>(draw.Next() % 3);
  // Every tenth pair of pieces, so that both kinds are rendered.
  const Imaging imaging = ImagingOf(piece / 2);
  Episode episode(PlacedScene(seed, placed), ModelsOf(TunnelTargets()), imaging);
  EllipsoidTally tally;
  for (std::size_t trigger = 0; trigger < kEllipsoidFrames; ++trigger) {
    const auto& points =
        episode.Expose(trigger).fixes.targets[placed.target.name == "one" ? 0 : 1].state.points;
    const auto status = static_cast<std::size_t>(points.status);
    if (points.status != stereo::FixStatus::kTracked && points.status != stereo::FixStatus::kRecovered)
      continue;
    const auto truths = episode.GetWorld().TruthAt(trigger);
    const auto how = static_cast<std::size_t>(imaging);
    ++tally.positions[status][how];
    if (Judge(points, truths[0], truths).nees <= kChi95) ++tally.inside[status][how];
  }
  return tally;
}

void ReportEllipsoids(const EllipsoidTally& sum, const std::string& at, SuiteReport& report) {
  constexpr std::array<const char*, 2> kStatus{"tracked", "recovered"};
  for (std::size_t status = 0; status < 2; ++status) {
    const auto pct = [&](std::size_t inside, std::size_t positions) {
      return positions == 0 ? NAN : 100.0 * static_cast<double>(inside) / static_cast<double>(positions);
    };
    const auto& inside = sum.inside[status];
    const auto& positions = sum.positions[status];
    const double share = pct(inside[0] + inside[1], positions[0] + positions[1]);
    const std::string what = std::string(kStatus[status]) + " at " + at;
    report.AtLeast("95 % ellipsoids that hold, " + what, share, 93, "%");
    report.AtMost("the same", share, 97, "%");
    for (const Imaging imaging : {Imaging::kCentroids, Imaging::kRendered}) {
      const auto how = static_cast<std::size_t>(imaging);
      report.Inform(std::string("  of them ") + HowImaged(imaging) + ", " + std::to_string(positions[how]),
                    pct(inside[how], positions[how]), "%");
    }
  }
}

/// Squared deviations of a target at rest, summed over pieces.
struct StaticTally {
  double freedom = 0;       ///< degrees of freedom
  double led_z_m2 = 0;      ///< of the LEDs' z, mean over the four
  double bound_z_m2 = 0;    ///< what the bound says of the same, times the freedom
  double led_m2 = 0;        ///< of the LEDs in all three axes, mean over the four
  double epicenter_m2 = 0;  ///< of the epicenter from the rigid fit

  void Add(const StaticTally& other) {
    freedom += other.freedom;
    led_z_m2 += other.led_z_m2, bound_z_m2 += other.bound_z_m2;
    led_m2 += other.led_m2, epicenter_m2 += other.epicenter_m2;
  }
};

constexpr std::size_t kStaticFrames = 40;

/// The bound of the z of one LED, m^2.
double BoundZM2(const Episode& episode, std::size_t led) {
  const sim::World& world = episode.GetWorld();
  std::array<double, 2> noise_px{};
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto seen = world.Receive(led, side, 0);
    ADIT_REQUIRE(seen);
    noise_px[static_cast<std::size_t>(side)] = episode.GetImaging() == Imaging::kRendered
                                                   ? DiscBoundPx(world, seen->disc)
                                                   : CentroidNoisePx(world.Painter().Value(seen->disc, 0));
  }
  return PointBoundM2(world, world.TruthAt(0)[0].leds_m[led], noise_px)(2, 2);
}

StaticTally MeasurePiece(std::uint64_t seed, double distance_m, Imaging imaging) {
  const base::Target target = TunnelTargets()[1];  // its epicenter is the middle of the bar
  sim::Scene scene = PlacedScene(seed, {target, distance_m});
  scene.sensor.glare = 0;  // the bound knows of none
  Episode episode(std::move(scene), ModelsOf({target}), imaging);
  std::array<Spread, base::kLedCount> leds;
  Spread epicenter;
  for (std::size_t trigger = 0; trigger < kStaticFrames; ++trigger) {
    const auto& points = episode.Expose(trigger).fixes.targets[0].state.points;
    if (points.status != stereo::FixStatus::kTracked) continue;
    epicenter.Add(points.epicenter_b_m);
    for (std::size_t i = 0; i < leds.size(); ++i) leds[i].Add(points.leds_b_m[i]);
  }
  StaticTally tally;
  if (epicenter.Count() < 2) return tally;
  tally.freedom = static_cast<double>(epicenter.Count() - 1);
  tally.epicenter_m2 = epicenter.Squares().sum();
  for (std::size_t i = 0; i < leds.size(); ++i) {
    tally.led_z_m2 += leds[i].Squares().z() / base::kLedCount;
    tally.led_m2 += leds[i].Squares().sum() / base::kLedCount;
    tally.bound_z_m2 += tally.freedom * BoundZM2(episode, i) / base::kLedCount;
  }
  return tally;
}

}  // namespace

SuiteReport MeasureEllipsoid(const CaseOrder& order) {
  constexpr std::array<double, 3> kDistancesM{20, 50, 100};
  const std::size_t each = std::max<std::size_t>(20, 2 * order.CountOr(2'000) / kEllipsoidFrames);
  const auto tallies = WorkInParallel<EllipsoidTally>(
      "ellipsoid", kDistancesM.size() * each,
      [&](std::size_t i) { return CountEllipsoids(PieceSeed(order, i), kDistancesM[i / each], i % each); });
  SuiteReport report;
  report.how =
      std::to_string(each * kEllipsoidFrames / 2) +
      " positions a distance and status, a tenth of them rendered; bars that move, LED peaks 60 to 200 DN";
  for (std::size_t d = 0; d < kDistancesM.size(); ++d) {
    EllipsoidTally sum;
    for (std::size_t i = d * each; i < (d + 1) * each; ++i) {
      for (std::size_t status = 0; status < 2; ++status) {
        for (std::size_t how = 0; how < 2; ++how) {
          sum.positions[status][how] += tallies[i].positions[status][how];
          sum.inside[status][how] += tallies[i].inside[status][how];
        }
      }
    }
    ReportEllipsoids(sum, std::to_string(static_cast<int>(kDistancesM[d])) + " m", report);
  }
  return report;
}

SuiteReport MeasureStatic(const CaseOrder& order) {
  constexpr std::array<double, 5> kDistancesM{20, 30, 50, 80, 100};
  const std::size_t each = std::max<std::size_t>(20, order.CountOr(4'000) / kStaticFrames);
  const auto tallies = WorkInParallel<StaticTally>("static", kDistancesM.size() * each, [&](std::size_t i) {
    return MeasurePiece(PieceSeed(order, i), kDistancesM[i / each], ImagingOf(i % each));
  });
  SuiteReport report;
  report.how =
      std::to_string(each * kStaticFrames) +
      " frames a distance of a bar at rest in many places, base 9 m, LED peak 200 DN, a tenth rendered";
  for (const Imaging imaging : {Imaging::kCentroids, Imaging::kRendered}) {
    for (std::size_t d = 0; d < kDistancesM.size(); ++d) {
      StaticTally sum;
      for (std::size_t i = 0; i < each; ++i) {
        if (ImagingOf(i) == imaging) sum.Add(tallies[d * each + i]);
      }
      const std::string at =
          " at " + std::to_string(static_cast<int>(kDistancesM[d])) + " m, " + HowImaged(imaging);
      report.Inform("single LEDs' spread of z" + at, 1e3 * std::sqrt(sum.led_z_m2 / sum.freedom), "mm", 3);
      report.AtMost("that over the bound" + at, std::sqrt(sum.led_z_m2 / sum.bound_z_m2), 1.15, "", 3);
      report.AtLeast("single LEDs' over the epicenter's" + at, std::sqrt(sum.led_m2 / sum.epicenter_m2), 1.6,
                     "", 3);
    }
  }
  return report;
}

}  // namespace adit::host
