#include "host/filmed_calibration.h"

#include <memory>

#include "host/bar_finder.h"
#include "host/simulated_blobs.h"
#include "host/simulated_camera.h"
#include "host/tunnel.h"

namespace adit::host {
namespace {

using base::Side;
using Eigen::Vector3d;

constexpr double kRateHz = 60, kExposureS = 0.0005;
constexpr double kStandsS = 0.005;  // about the exposure's middle; the longest exposure is 8 ms
constexpr int kLamps = 14, kMachines = 3;
constexpr std::size_t kHiddenEvery = 5;

double MiddleS(std::size_t frame) { return static_cast<double>(frame) / kRateHz + kExposureS / 2; }

/// The bar at each of its places in turn.
sim::MotionPtr Waving(const CalibrationDraw& draw) {
  sim::Course course;
  for (std::size_t i = 0; i < draw.bars.size(); ++i) {
    for (const double shift_s : {-kStandsS, kStandsS})
      course.waypoints.push_back({MiddleS(i) + shift_s, draw.bars[i].led1_m, draw.bars[i].direction});
  }
  return sim::MakePath(course, {});
}

/// A plate between an LED of the bar and one eye. Its middle is off the LED by less than half its size.
sim::Occluder PlateBefore(const CalibrationDraw& draw, const sim::SceneTarget& bar, std::size_t frame,
                          sim::Random& random) {
  constexpr double kBeforeM = 0.6;  // from the LED towards the eye: the other eye sees past
  const auto led = static_cast<std::size_t>(random.Uniform(0, base::kLedCount));
  const Vector3d led_m = draw.bars[frame].led1_m + bar.target.leds_m[led] * draw.bars[frame].direction;
  const Vector3d eye_m = random.Uniform() < 0.5 ? Vector3d(Vector3d::Zero())
                                                : Vector3d(draw.rig.AsRig().T_r_l.Inverse().translation_m);
  sim::Occluder plate;
  plate.width_m = random.Uniform(0.05, 0.4), plate.height_m = random.Uniform(0.05, 0.4);
  const Vector3d aside_m(random.Uniform(-0.5, 0.5) * plate.width_m,
                         random.Uniform(-0.5, 0.5) * plate.height_m, 0);
  plate.motion = sim::MakePath({{{0, led_m + kBeforeM * (eye_m - led_m).normalized() + aside_m}}}, {});
  plate.active = {MiddleS(frame) - 0.5 / kRateHz, MiddleS(frame) + 0.5 / kRateHz};
  return plate;
}

}  // namespace

sim::Scene SceneOf(const CalibrationPlan& plan, const CalibrationDraw& draw, std::uint64_t seed) {
  constexpr double kPeakDn = 200;
  sim::Scene scene;
  scene.seed = seed;
  scene.rig = draw.rig.AsRig();
  scene.rate_hz = kRateHz, scene.exposure_s = kExposureS;
  scene.frames = static_cast<long>(draw.bars.size());
  scene.auto_exposure = sim::AutoExposure{};
  scene.auto_exposure->peak_dn = kPeakDn;
  sim::SceneTarget bar;
  bar.target = draw.input.targets.front();
  for (double& place_m : bar.target.leds_m) place_m *= draw.length_scale;
  bar.motion = Waving(draw);
  const double distance_m = 0.5 * (plan.nearest_m + plan.farthest_m);
  bar.surface_dn = sim::SurfaceOfPeak(
      kPeakDn, scene.rig.left.fu_px * bar.target.led_diameter_m / 2 / distance_m, scene.sensor.psf_sigma_px);
  scene.targets.push_back(std::move(bar));
  return scene;
}

void AddClutter(const CalibrationDraw& draw, std::uint64_t seed, sim::Scene& scene) {
  Tunnel tunnel(seed, scene.rig);
  tunnel.AddLamps(kLamps);
  for (int i = 0; i < kMachines; ++i) tunnel.AddHeadlights(static_cast<double>(scene.frames) / kRateHz);
  scene.lamps = tunnel.Scene().lamps;
  for (std::size_t frame = 0; frame < draw.bars.size(); frame += kHiddenEvery)
    scene.occluders.push_back(PlateBefore(draw, scene.targets.front(), frame, tunnel.Draw()));
}

std::vector<StereoBar> FindBars(const sim::Scene& scene, const CalibrationInput& input, Imaging imaging,
                                double noise_px) {
  const sim::World world(scene);
  BarFinder finder(input.left, input.right, ModelsOf(input.targets));
  std::vector<StereoBar> bars;
  if (imaging == Imaging::kRendered) {
    SimulatedCamera left(world, Side::kLeft), right(world, Side::kRight);
    for (std::uint64_t trigger = 0; trigger < static_cast<std::uint64_t>(scene.frames); ++trigger) {
      finder.Search(left.Expose(trigger), right.Expose(trigger));
      finder.AppendBars(bars);
    }
    return bars;
  }
  SimulatedBlobs centroids(world);
  centroids.FixNoise(noise_px);
  const auto blobs = std::make_unique<std::array<detect::BlobSet, 2>>();  // too large for a stack
  for (std::uint64_t trigger = 0; trigger < static_cast<std::uint64_t>(scene.frames); ++trigger) {
    for (const Side side : {Side::kLeft, Side::kRight})
      centroids.Expose(side, trigger, (*blobs)[static_cast<std::size_t>(side)]);
    finder.Search((*blobs)[0], (*blobs)[1]);
    finder.AppendBars(bars);
  }
  return bars;
}

}  // namespace adit::host
