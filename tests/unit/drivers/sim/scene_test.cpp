#include "drivers/sim/scene.h"

#include <cmath>
#include <filesystem>

#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::sim::LoadScene;
using adit::sim::Scene;
using adit::tests::kBarBuild;
using adit::tests::kBarKeys;
using adit::tests::kSmallRig;
using adit::tests::SceneOf;
using adit::tests::ScratchFolder;
using adit::tests::TryScene;

namespace {

std::string RefusalOf(const std::string& text) {
  const auto scene = TryScene(text);
  return scene ? "accepted" : scene.error().Line();
}

}  // namespace

TEST_GROUP(Scene){};

TEST(Scene, HasTheDocumentedDefaults) {
  const Scene scene = SceneOf(kSmallRig);
  LONGS_EQUAL(1, scene.seed);
  DOUBLES_EQUAL(60, scene.rate_hz, 0);
  LONGS_EQUAL(600, scene.frames);
  LONGLONGS_EQUAL(1'700'000'000'000'000'000, scene.start_ns);
  DOUBLES_EQUAL(0.001, scene.exposure_s, 0);
  LONGS_EQUAL(8, scene.sensor.bits);
  DOUBLES_EQUAL(6, scene.sensor.background_dn, 0);
  DOUBLES_EQUAL(1.5, scene.sensor.read_noise_dn, 0);
  DOUBLES_EQUAL(40, scene.sensor.electrons_per_dn, 0);
  DOUBLES_EQUAL(1.3, scene.sensor.psf_sigma_px, 0);
  CHECK_FALSE(scene.auto_exposure.has_value());
  CHECK_TRUE(scene.targets.empty() && scene.lamps.empty() && scene.occluders.empty() && !scene.water);
}

TEST(Scene, DescribesARigWhoseAxesMeet) {
  const auto rig = SceneOf(
                       "rig: {base_m: 9, focal_px: 3378, converge_m: 35, left: {distortion: [-0.1, 0.02, "
                       "0.001, 0.002], centre_px: [700, 500]}, right: {roll_deg: 3, pitch_deg: -2}}\n")
                       .rig;
  DOUBLES_EQUAL(9, rig.BaselineM(), 1e-12);
  LONGS_EQUAL(1400, rig.left.width_px);
  DOUBLES_EQUAL(-0.1, rig.left.k1, 0);
  DOUBLES_EQUAL(0.002, rig.left.p2, 0);
  DOUBLES_EQUAL(700, rig.left.cu_px, 0);
  DOUBLES_EQUAL(0, rig.right.k1, 0);
  DOUBLES_EQUAL(699.5, rig.right.cu_px, 0);
  // The left axis at the convergence distance, seen from the right: pitch alone moves it off the right axis.
  const double toe_rad = std::atan2(4.5, 35.0);
  const Eigen::Vector3d meet_m = rig.T_r_l * Eigen::Vector3d(0, 0, 35 / std::cos(toe_rad));
  const double off_axis_rad = std::atan2(meet_m.head<2>().norm(), meet_m.z());
  DOUBLES_EQUAL(2 * 3.14159265358979 / 180, off_axis_rad, 1e-9);
}

TEST(Scene, ReadsRigAndTargetFilesBesideIt) {
  const ScratchFolder scratch;
  scratch.Write("rig.yaml", adit::optics::FormatRig(SceneOf(kSmallRig).rig));
  scratch.Write("bars/a.yaml", "name: a\nleds_m: [0, 0.25, 0.65, 1.5]\nepicenter_m: 2\n");
  const auto scene = LoadScene(
      scratch.Write("scene.yaml", "rig_file: rig.yaml\ntargets: [{file: bars/a.yaml, at_m: [0, 0, 20]}]\n"));
  CHECK_TRUE(static_cast<bool>(scene));
  DOUBLES_EQUAL(1, scene->rig.BaselineM(), 1e-9);
  STRCMP_EQUAL("a", scene->targets[0].target.name.c_str());
  DOUBLES_EQUAL(2, scene->targets[0].target.epicenter_m, 0);
  STRCMP_EQUAL("scene", scene->name.c_str());
}

TEST(Scene, ReplacesTheSeedOnRequest) {
  const ScratchFolder scratch;
  const std::string path = scratch.Write("scene.yaml", kSmallRig + "seed: 3\ntunnel_lamps: {count: 5}\n");
  const auto own = LoadScene(path), same = LoadScene(path, 3), other = LoadScene(path, 4);
  LONGS_EQUAL(4, other->seed);
  CHECK_TRUE(own->lamps[0].place_m == same->lamps[0].place_m);
  CHECK_FALSE(own->lamps[0].place_m == other->lamps[0].place_m);
}

TEST(Scene, DrawsTunnelLampsOnWallsAndCrown) {
  const Scene scene = SceneOf(kSmallRig +
                              "tunnel_lamps: {count: 200, nearest_m: 10, farthest_m: 60, half_width_m: 4, "
                              "height_m: 3, diameter_m: [0.1, 0.2], surface_dn: [50, 60]}\n");
  LONGS_EQUAL(200, scene.lamps.size());
  int walls = 0;
  for (const auto& lamp : scene.lamps) {
    const bool wall = std::abs(std::abs(lamp.place_m.x()) - 4) < 1e-12;
    const bool crown = std::abs(lamp.place_m.y() + 3) < 1e-12;
    CHECK_TRUE(wall || crown);
    CHECK_TRUE(lamp.place_m.z() >= 10 && lamp.place_m.z() <= 60 && std::abs(lamp.place_m.x()) <= 4);
    CHECK_TRUE(lamp.diameter_m >= 0.1 && lamp.diameter_m <= 0.2 && lamp.surface_dn >= 50 &&
               lamp.surface_dn <= 60);
    walls += wall ? 1 : 0;
  }
  CHECK_TRUE(walls > 100 && walls < 170);
}

TEST(Scene, ReadsEveryKeyOfItsDocumentation) {
  const Scene scene = SceneOf(
      "seed: 5\nrate_hz: 25\nframes: 10\nstart_s: 12\nexposure_s: 0.002\n"
      "auto_exposure: {peak_dn: 150, shortest_s: 0.0001, longest_s: 0.01}\nframe: middle\n" +
      kSmallRig +
      "sensor: {bits: 10, background_dn: 5, read_noise_dn: 1, electrons_per_dn: 30, psf_sigma_px: 1.1, "
      "glare: 0.01, glare_sigma_px: 9}\n"
      "fog: {per_m: 0.01, veil_dn: 2, glow: 0.1, glow_sigma_px: 20}\n"
      "targets: [{" +
      kBarKeys +
      ", epicenter_m: -0.2, wave: {nearest_m: 15, farthest_m: 25, lean_max: 0.5, step_s: 1},"
      " off: [{led: 4, from_s: 1, to_s: 2}]}]\n"
      "machines:\n  - path: {curve: spline, repeat: true, waypoints: [{t_s: 0, at_m: [0, 0, 20]}, {t_s: 1, "
      "at_m: [1, 0, 20], direction: [1, 0, 1]}]}\n"
      "    targets: [{name: b, leds_m: [0, 1, 2, 4], at_m: [0, 0, 0], direction: [0, 2, 0]}]\n"
      "    lamps: [{at_m: [1, 0, 0], diameter_m: 0.3, surface_dn: 10, off: [{from_s: 0, to_s: 1}]}]\n"
      "    hull: {at_m: [0, 0, 1], width_m: 2, height_m: 1}\n"
      "  - drive: {from_m: [0, 0, 20], to_m: [0, 0, 30], duration_s: 5, weave_m: 0.1, weave_period_s: 3, "
      "vibration_m: 0.001, vibration_hz: 30}\n"
      "lamps: [{at_m: [0, 0, 30]}, {path: {waypoints: [{t_s: 0, at_m: [0, 0, 30]}]}}]\n"
      "occluders: [{at_m: [0, 0, 5], width_m: 0.1, height_m: 0.2, from_s: 1, to_s: 2}]\n"
      "water: {y_m: 2, nearest_m: 1, farthest_m: 50, reflectivity: 0.2, wobble_rad: 0.02}\n");
  LONGS_EQUAL(2, scene.targets.size());
  LONGS_EQUAL(3, scene.lamps.size());
  LONGS_EQUAL(2, scene.occluders.size());
  DOUBLES_EQUAL(1, scene.targets[1].direction.y(), 1e-12);
  LONGS_EQUAL(1, scene.targets[0].off[3].size());
  DOUBLES_EQUAL(0.2, scene.water->reflectivity, 0);
  DOUBLES_EQUAL(150, scene.auto_exposure->peak_dn, 0);
  LONGS_EQUAL(10, scene.sensor.bits);
  // The middle of the baseline stands half a metre to the right of the left camera, along the baseline.
  DOUBLES_EQUAL(0.5, scene.T_b_g.translation_m.norm(), 1e-12);
}

TEST(Scene, RefusesEveryMistakeInOneLineThatNamesIt) {
  const std::string bar = "targets: [{" + kBarKeys;
  const std::pair<std::string, const char*> cases[] = {
      {"", "must be a map"},
      {"rig: {", "is not YAML"},
      {"seed: 1\n", "rig: is missing"},
      {kSmallRig + "sed: 1\n", "sed: is not known here"},
      {kSmallRig + "rate_hz: 0\n", "rate_hz: is '0'"},
      {kSmallRig + "rate_hz: 500\nexposure_s: 0.01\n", "rate_hz: leaves no time for an exposure"},
      {kSmallRig + "auto_exposure: {longest_s: 0.5}\n", "rate_hz: leaves no time"},
      {kSmallRig + "auto_exposure: {shortest_s: 0.01, longest_s: 0.001}\n",
       "auto_exposure.longest_s: is '0.001'"},
      {kSmallRig + "frames: 1.5\n", "frames: is '1.5'"},
      {kSmallRig + "frame: site\n", "frame: is 'site'"},
      {kSmallRig + "rig_file: rig.yaml\n", "rig: stands beside rig_file"},
      {"rig_file: nowhere.yaml\n", "rig_file: cannot be used: "},
      {"rig: {base_m: 0, focal_px: 800, converge_m: 20}\n", "rig.base_m: is '0'"},
      {"rig: {base_m: 1, focal_px: 800, converge_m: 20, left: {roll_deg: 1}}\n",
       "rig.left.roll_deg: is not known"},
      {kSmallRig + "sensor: {bits: 9}\n", "sensor.bits: is 9; it must be one of: 8, 10, 12"},
      {kSmallRig + "sensor: {psf_sigma_px: nan}\n", "sensor.psf_sigma_px: is 'nan'"},
      {kSmallRig + bar + "}]\n", "targets[0]: must have exactly one of at_m, path and drive, has 0"},
      {kSmallRig + bar + ", at_m: [0, 0, 20], wave: {}}]\n", "targets[0].at_m: stands beside wave"},
      {kSmallRig + bar + ", at_m: [0, 20]}]\n", "targets[0].at_m: is a list of 2"},
      {kSmallRig + bar + ", at_m: [0, 0, 20], direction: [0, 0, 0]}]\n",
       "targets[0].direction: is the zero vector"},
      {kSmallRig + bar + ", at_m: [0, 0, 20]}, {" + kBarKeys + ", at_m: [0, 0, 30]}]\n",
       "targets[1].name: 'bar' is taken"},
      {kSmallRig + bar + ", at_m: [0, 0, 20], off: [{led: 5, from_s: 0, to_s: 1}]}]\n",
       "targets[0].off[0].led: is '5'"},
      {kSmallRig + bar + ", wave: {nearest_m: 0.5, farthest_m: 0.6}}]\n", "targets[0].wave: finds no place"},
      {kSmallRig + "frames: 1e7\n" + bar + ", wave: {step_s: 0.01}}]\n", "targets[0].wave.step_s: makes"},
      {kSmallRig + bar + ", path: {waypoints: []}}]\n", "targets[0].path.waypoints: is empty"},
      {kSmallRig + bar + ", path: {waypoints: [{t_s: 1, at_m: [0, 0, 1]}, {t_s: 1, at_m: [0, 0, 1]}]}}]\n",
       "targets[0].path.waypoints[1].t_s: is not later"},
      {kSmallRig + "targets: [{file: nowhere.yaml, at_m: [0, 0, 1]}]\n", "targets[0].file: cannot be used: "},
      {kSmallRig + "targets: [{name: b, leds_m: [0, 1, 2], at_m: [0, 0, 1]}]\n",
       "targets[0].leds_m: is a list of 3"},
      {kSmallRig + "targets: [{name: b, leds_m: [0, 2, 1, 3], at_m: [0, 0, 1]}]\n",
       "targets[0].leds_m: must start at 0 and ascend"},
      {kSmallRig + "targets: [{name: ../b, leds_m: [0, 1, 2, 4], at_m: [0, 0, 1]}]\n",
       "targets[0].name: must not hold"},
      {kSmallRig + "targets: bar\n", "targets: is 'bar'; it must be a list of maps"},
      {kSmallRig + "machines: [{drive: {from_m: [0, 0, 9], to_m: [0, 5, 9], duration_s: 5}}]\n",
       "machines[0].drive.to_m: must differ"},
      {kSmallRig + "lamps: [{at_m: [0, 0, 9], off: [{from_s: 2, to_s: 1}]}]\n",
       "lamps[0].off[0].to_s: is '1'"},
      {kSmallRig + "tunnel_lamps: {count: 3, diameter_m: [0.3, 0.1]}\n",
       "tunnel_lamps.diameter_m: must ascend"},
      {kSmallRig + "occluders: [{at_m: [0, 0, 9], width_m: 1}]\n", "occluders[0].height_m: is missing"},
      {kSmallRig + "water: {}\n", "water.y_m: is missing"},
  };
  for (const auto& [text, said] : cases) {
    const std::string line = RefusalOf(text);
    STRCMP_CONTAINS(said, line.c_str());
    STRCMP_CONTAINS("scene.yaml", line.c_str());
    CHECK_TRUE(line.find('\n') == std::string::npos);
  }
}

TEST(Scene, OfEveryShippedFileLoadsAndShowsItsTargetsFromTheStart) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("host/scenes")) {
    if (entry.path().filename().string().rfind("bar_", 0) == 0) continue;
    const auto scene = LoadScene(entry.path().string());
    if (!scene) FAIL(scene.error().Line().c_str());
    LONGS_EQUAL(9, std::lround(scene->rig.BaselineM()));
    ++count;
  }
  CHECK_TRUE(count >= 4);
}

TEST(Scene, TurnsAPeakIntoTheBrightnessOfADisc) {
  // Much larger than the PSF: the peak is the surface. Much smaller: it spreads by R^2 / (2 sigma^2).
  DOUBLES_EQUAL(100, adit::sim::SurfaceOfPeak(100, 10, 1), 1e-9);
  DOUBLES_EQUAL(100 * 2 / (0.01 * 0.01), adit::sim::SurfaceOfPeak(100, 0.01, 1), 100);
}
