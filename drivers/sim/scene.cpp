#include "drivers/sim/scene.h"

#include <cmath>
#include <filesystem>
#include <set>

#include "drivers/sim/random.h"
#include "drivers/sim/scene_keys.h"

namespace adit::sim {
namespace {

using base::Range;
using base::YamlReader;
using Eigen::Vector3d;

constexpr Range kBrightnessDn{0, 1e6};  // a million times the noise: the sun in the mirror
constexpr Range kShare{0, 1};
constexpr Range kExposureS{1e-6, 1};

/// Reads one scene; keeps what several keys need.
class SceneReader {
 public:
  SceneReader(YamlReader in, std::string path) : in_(std::move(in)), path_(std::move(path)) {}

  base::Result<Scene> Read(std::optional<std::uint64_t> seed) {
    scene_.name = std::filesystem::path(path_).stem().string();
    scene_.seed = static_cast<std::uint64_t>(in_.IntegerOr("seed", 1, {0, 9e15}));
    if (seed) scene_.seed = *seed;
    ReadTimes();
    scene_.rig = ReadRig(in_, path_);
    if (!in_.Ok()) return in_.Finish().error();  // nothing below makes sense without a rig
    if (in_.ChoiceOr("frame", "rig", {"rig", "middle"}) == "middle") scene_.T_b_g = MiddleFrame(scene_.rig);
    ground_ = GroundMotion(scene_.T_b_g);
    ReadSensor();
    ReadFog();
    for (YamlReader& item : in_.Items("targets")) ReadFreeTarget(item);
    for (YamlReader& item : in_.Items("machines")) ReadMachine(item);
    for (YamlReader& item : in_.Items("lamps")) ReadFreeLamp(item);
    if (in_.Has("tunnel_lamps")) DrawTunnelLamps(in_.Child("tunnel_lamps"));
    for (YamlReader& item : in_.Items("occluders")) ReadOccluder(item);
    ReadWater();
    if (auto done = in_.Finish(); !done) return done.error();
    return std::move(scene_);
  }

 private:
  void ReadTimes() {
    scene_.rate_hz = in_.NumberOr("rate_hz", 60, {0.01, 1000});
    scene_.frames = in_.IntegerOr("frames", 600, {1, 1e7});
    scene_.start_ns = in_.IntegerOr("start_s", scene_.start_ns / base::kNsPerS, {0, 9e9}) * base::kNsPerS;
    scene_.exposure_s = in_.NumberOr("exposure_s", 0.001, kExposureS);
    double longest_s = scene_.exposure_s;
    if (in_.Has("auto_exposure")) {
      YamlReader in = in_.Child("auto_exposure");
      AutoExposure& automatic = scene_.auto_exposure.emplace();
      automatic.peak_dn = in.NumberOr("peak_dn", 200, {1, 255});
      automatic.shortest_s = in.NumberOr("shortest_s", 0.0002, kExposureS);
      automatic.longest_s = in.NumberOr("longest_s", 0.008, {automatic.shortest_s, kExposureS.max});
      longest_s = automatic.longest_s;
    }
    if (in_.Ok() && longest_s * scene_.rate_hz > 1)
      in_.Refuse("rate_hz", "leaves no time for an exposure of " + std::to_string(longest_s) + " s");
  }

  void ReadSensor() {
    if (!in_.Has("sensor")) return;
    YamlReader in = in_.Child("sensor");
    Sensor& sensor = scene_.sensor;
    sensor.bits = static_cast<int>(in.IntegerOr("bits", sensor.bits, {8, 16}));
    if (sensor.bits != 8 && sensor.bits != 10 && sensor.bits != 12)
      in.Refuse("bits", "is " + std::to_string(sensor.bits) + "; it must be one of: 8, 10, 12");
    sensor.background_dn = in.NumberOr("background_dn", sensor.background_dn, {0, 200});
    sensor.read_noise_dn = in.NumberOr("read_noise_dn", sensor.read_noise_dn, {0, 50});
    sensor.electrons_per_dn = in.NumberOr("electrons_per_dn", sensor.electrons_per_dn, {0.1, 1e6});
    sensor.psf_sigma_px = in.NumberOr("psf_sigma_px", sensor.psf_sigma_px, {0.3, 20});
    sensor.glare = in.NumberOr("glare", sensor.glare, kShare);
    sensor.glare_sigma_px = in.NumberOr("glare_sigma_px", sensor.glare_sigma_px, {1, 200});
  }

  void ReadFog() {
    if (!in_.Has("fog")) return;
    YamlReader in = in_.Child("fog");
    scene_.fog.per_m = in.NumberOr("per_m", 0, {0, 10});
    scene_.fog.veil_dn = in.NumberOr("veil_dn", 0, {0, 255});
    scene_.fog.glow = in.NumberOr("glow", 0, kShare);
    scene_.fog.glow_sigma_px = in.NumberOr("glow_sigma_px", scene_.fog.glow_sigma_px, {1, 200});
  }

  SceneTarget ReadTargetLooks(YamlReader& in) {
    SceneTarget target;
    target.target = ReadTarget(in, path_);
    if (in.Ok() && !names_.insert(target.target.name).second)
      in.Refuse("name", "'" + target.target.name + "' is taken by another target of the scene");
    const double peak_dn = in.NumberOr("peak_dn", 200, kBrightnessDn);
    const double reference_m = in.NumberOr("reference_m", 30, {0.1, 1000});
    const double radius_px = scene_.rig.left.fu_px * target.target.led_diameter_m / 2 / reference_m;
    target.surface_dn = SurfaceOfPeak(peak_dn, radius_px, scene_.sensor.psf_sigma_px);
    for (YamlReader& item : in.Items("off")) {
      const long led = item.Integer("led", {1, base::kLedCount});
      const Interval interval{item.Number("from_s", kTimeS), item.Number("to_s", kTimeS)};
      if (item.Ok()) target.off[static_cast<std::size_t>(led - 1)].push_back(interval);
    }
    return target;
  }

  void ReadFreeTarget(YamlReader& in) {
    SceneTarget target = ReadTargetLooks(in);
    if (!in.Has("wave")) {
      target.motion = ReadMotion(in, scene_.T_b_g);
    } else {
      for (const char* other : {"at_m", "path", "drive"}) {
        if (in.Has(other)) in.Refuse(other, "stands beside wave; give one of them");
      }
      target.motion = ReadWave(in.Child("wave"), target.target);
    }
    scene_.targets.push_back(std::move(target));
  }

  MotionPtr ReadWave(YamlReader in, const base::Target& target) {
    Wave wave;
    wave.nearest_m = in.NumberOr("nearest_m", wave.nearest_m, {0.5, 1000});
    wave.farthest_m = in.NumberOr("farthest_m", wave.farthest_m, {wave.nearest_m, 1000});
    wave.lean_max = in.NumberOr("lean_max", wave.lean_max, kShare);
    wave.step_s = in.NumberOr("step_s", wave.step_s, {0.01, 1000});
    wave.length_s = static_cast<double>(scene_.frames) / scene_.rate_hz;
    wave.seed = scene_.seed;
    constexpr double kStepsMax = 100'000;
    if (in.Ok() && wave.length_s / wave.step_s > kStepsMax)
      in.Refuse("step_s", "makes " + std::to_string(wave.length_s / wave.step_s) +
                              " steps of the scene; it must be 100000 at most");
    if (!in.Ok()) return ground_;
    const auto waypoints = WaveBar(wave, target, scene_.rig);
    if (waypoints.empty()) {
      in.Refuse("", "finds no place where both images hold the whole bar; see nearest_m and farthest_m");
      return ground_;
    }
    return MakePath({waypoints, Curve::kSpline, true}, {});  // waypoints stand in the rig frame already
  }

  void ReadMachine(YamlReader& in) {
    const MotionPtr motion = ReadMotion(in, scene_.T_b_g);
    for (YamlReader& item : in.Items("targets")) {
      SceneTarget target = ReadTargetLooks(item);
      target.motion = motion;
      target.led1_m = ReadVector(item, "at_m");
      target.direction = ReadDirection(item, "direction");
      scene_.targets.push_back(std::move(target));
    }
    for (YamlReader& item : in.Items("lamps")) {
      Light lamp = ReadLampLooks(item);
      lamp.motion = motion;
      lamp.place_m = ReadVector(item, "at_m");
      scene_.lamps.push_back(std::move(lamp));
    }
    if (in.Has("hull")) {
      YamlReader hull = in.Child("hull");
      const double width_m = hull.Number("width_m", {0, 100}), height_m = hull.Number("height_m", {0, 100});
      scene_.occluders.push_back({motion, ReadVector(hull, "at_m"), width_m, height_m, {}});
    }
  }

  Light ReadLampLooks(YamlReader& in) {
    Light lamp;
    lamp.diameter_m = in.NumberOr("diameter_m", lamp.diameter_m, {0.001, 10});
    lamp.surface_dn = in.NumberOr("surface_dn", lamp.surface_dn, kBrightnessDn);
    lamp.off = ReadIntervals(in, "off");
    return lamp;
  }

  void ReadFreeLamp(YamlReader& in) {
    Light lamp = ReadLampLooks(in);
    lamp.motion = ReadMotion(in, scene_.T_b_g);
    scene_.lamps.push_back(std::move(lamp));
  }

  /// Two walls and a crown; lamps stand apart along the tunnel but for a jitter.
  void DrawTunnelLamps(YamlReader in) {
    const long count = in.Integer("count", {0, 10000});
    const double nearest_m = in.NumberOr("nearest_m", 15, {0.5, 1000});
    const double farthest_m = in.NumberOr("farthest_m", 150, {nearest_m, 2000});
    const double half_width_m = in.NumberOr("half_width_m", 5, {0.1, 100});
    const double height_m = in.NumberOr("height_m", 3, {0.1, 100});
    const auto diameter_m = ReadPairOr(in, "diameter_m", {0.05, 0.3}, {0.001, 10});
    const auto surface_dn = ReadPairOr(in, "surface_dn", {100, 3000}, kBrightnessDn);
    Random random(scene_.seed, 0x6c616d70);
    for (long i = 0; in.Ok() && i < count; ++i) {
      const double z_m = nearest_m + (farthest_m - nearest_m) * (static_cast<double>(i) + random.Uniform()) /
                                         static_cast<double>(count);
      const auto wall = random.Next() % 3;
      const double across_m = wall == 0   ? -half_width_m
                              : wall == 1 ? half_width_m
                                          : random.Uniform(-half_width_m, half_width_m);
      const double up_m = wall == 2 ? height_m : height_m * random.Uniform(-0.3, 1);
      Light lamp;
      lamp.motion = ground_;
      lamp.place_m = {across_m, -up_m, z_m};
      lamp.diameter_m = random.Uniform(diameter_m[0], diameter_m[1]);
      lamp.surface_dn = random.Uniform(surface_dn[0], surface_dn[1]);
      scene_.lamps.push_back(std::move(lamp));
    }
  }

  std::vector<double> ReadPairOr(YamlReader& in, const std::string& key, std::vector<double> fallback,
                                 Range range) {
    if (!in.Has(key)) return fallback;
    auto pair = in.Numbers(key, 2, range);
    if (in.Ok() && pair[0] > pair[1]) in.Refuse(key, "must ascend");
    return pair;
  }

  void ReadOccluder(YamlReader& in) {
    Occluder occluder;
    occluder.motion = ReadMotion(in, scene_.T_b_g);
    occluder.width_m = in.Number("width_m", {0, 1000});
    occluder.height_m = in.Number("height_m", {0, 1000});
    occluder.active.from_s = in.NumberOr("from_s", occluder.active.from_s, kTimeS);
    occluder.active.to_s = in.NumberOr("to_s", occluder.active.to_s, kTimeS);
    scene_.occluders.push_back(std::move(occluder));
  }

  void ReadWater() {
    if (!in_.Has("water")) return;
    YamlReader in = in_.Child("water");
    Water& water = scene_.water.emplace();
    water.y_m = in.Number("y_m", kSomewhereM);
    water.nearest_m = in.NumberOr("nearest_m", water.nearest_m, kSomewhereM);
    water.farthest_m = in.NumberOr("farthest_m", water.farthest_m, kSomewhereM);
    water.reflectivity = in.NumberOr("reflectivity", water.reflectivity, kShare);
    water.wobble_rad = in.NumberOr("wobble_rad", water.wobble_rad, {0, 0.5});
  }

  YamlReader in_;
  std::string path_;
  Scene scene_;
  MotionPtr ground_;
  std::set<std::string> names_;
};

}  // namespace

double SurfaceOfPeak(double peak_dn, double radius_px, double psf_sigma_px) {
  // A disc of radius R and brightness 1 under a Gaussian of sigma: 1 - exp(-R^2 / (2 sigma^2)) at its centre.
  return peak_dn / -std::expm1(-0.5 * radius_px * radius_px / (psf_sigma_px * psf_sigma_px));
}

base::Result<Scene> LoadScene(const std::string& path, std::optional<std::uint64_t> seed) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  return SceneReader(std::move(*in), path).Read(seed);
}

}  // namespace adit::sim
