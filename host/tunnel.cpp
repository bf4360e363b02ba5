#include "host/tunnel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/sim/projection.h"
#include "firmware/base/require.h"
#include "host/training.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kFocalPx = 3378;

bool InsideImage(const optics::CameraModel& camera, const Vector3d& point_m) {
  constexpr double kMarginPx = 15;  // a near LED and its surroundings
  const auto px = sim::ProjectPoint(camera, point_m);
  return px && px->x() > kMarginPx && px->y() > kMarginPx && px->x() < camera.width_px - 1 - kMarginPx &&
         px->y() < camera.height_px - 1 - kMarginPx;
}

sim::MotionPtr Still() {
  return sim::MakePath({{{0, Vector3d::Zero(), Vector3d::UnitX()}}, sim::Curve::kLinear, false}, {});
}

sim::MotionPtr Between(const sim::Waypoint& from, const sim::Waypoint& to) {
  return sim::MakePath({{from, to}, sim::Curve::kLinear, false}, {});
}

}  // namespace

std::vector<base::Target> TunnelTargets() {
  return {{"one", {0, 0.50, 1.25, 1.50}, 1.75, 0.04},
          {"two", {0, 0.65, 1.15, 1.50}, 0.75, 0.04},
          {"short", {0, 0.27, 0.62, 0.82}, 1.20, 0.04}};
}

std::vector<identify::Model> ModelsOf(const std::vector<base::Target>& targets) {
  std::vector<identify::Model> models;
  TrainingOptions options;
  options.focal_px = kFocalPx;
  for (const base::Target& target : targets) models.push_back(GeometryModel(target, options));
  return models;
}

optics::Rig TunnelRig(double base_m, double converge_m) {
  const double toe_rad = std::atan(base_m / 2 / converge_m);
  optics::Rig rig;
  rig.left = {kFocalPx, kFocalPx, 704.2, 508.9, -0.102, 0.11, 0.0003, -0.0002, 1400, 1024};
  rig.right = {kFocalPx, kFocalPx, 695.1, 514.3, -0.098, 0.10, -0.0002, 0.0004, 1400, 1024};
  rig.T_r_l.rotation =
      (Eigen::AngleAxisd(0.010, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.007, Vector3d::UnitX()) *
       Eigen::AngleAxisd(2 * toe_rad, Vector3d::UnitY()))
          .toRotationMatrix();
  rig.T_r_l.translation_m =
      -(rig.T_r_l.rotation * Vector3d(base_m * std::cos(toe_rad), 0, base_m * std::sin(toe_rad)));
  rig.calibration_id = "simulated";
  return rig;
}

Tunnel::Tunnel(std::uint64_t seed, const optics::Rig& rig) : random_(seed, 0x74756e6e656c) {
  scene_.seed = seed;
  scene_.rig = rig;
  scene_.sensor.glare = 0.01, scene_.sensor.glare_sigma_px = 10;
}

Vector3d Tunnel::DrawInView(double nearest_m, double farthest_m) {
  // A random pixel of the left image, or of the right one, at a random distance.
  const bool left = random_.Uniform() < 0.5;
  const optics::CameraModel& camera = left ? scene_.rig.left : scene_.rig.right;
  const double z_m = nearest_m * std::pow(farthest_m / nearest_m, random_.Uniform());
  const Vector3d place_m(z_m * (random_.Uniform(0, camera.width_px) - camera.cu_px) / camera.fu_px,
                         z_m * (random_.Uniform(0, camera.height_px) - camera.cv_px) / camera.fv_px, z_m);
  return left ? place_m : scene_.rig.T_r_l.Inverse() * place_m;
}

sim::Waypoint Tunnel::DrawPlace(double nearest_m, double farthest_m, double lean_max) {
  sim::Waypoint place;
  place.at_m = DrawInView(nearest_m, farthest_m);
  const double lean = random_.Uniform(-lean_max, lean_max), turn_rad = random_.Uniform(0, 2 * pi);
  const double across = std::sqrt(1 - lean * lean);
  place.direction = {across * std::cos(turn_rad), across * std::sin(turn_rad), lean};
  return place;
}

bool Tunnel::BothSee(const sim::Waypoint& place, const base::Target& target) const {
  return std::all_of(target.leds_m.begin(), target.leds_m.end(), [&](double led_m) {
    const Vector3d point_m = place.at_m + led_m * place.direction;
    return InsideImage(scene_.rig.left, point_m) && InsideImage(scene_.rig.right, scene_.rig.T_r_l * point_m);
  });
}

void Tunnel::AddTarget(const base::Target& target, const Ride& ride) {
  constexpr int kTries = 100000;
  sim::Waypoint from, to;
  bool seen = false;
  for (int i = 0; i < kTries && !seen; ++i) {
    from = DrawPlace(ride.nearest_m, ride.farthest_m, ride.lean_max);
    const double reach_m = ride.speed_max_mps * ride.seconds;
    to = from;
    to.t_s = ride.seconds;
    to.at_m +=
        reach_m * Vector3d(random_.Uniform(-0.2, 0.2), random_.Uniform(-0.05, 0.05), random_.Uniform(-1, 1));
    if (reach_m > 0) {
      const Vector3d turn(random_.Uniform(-0.1, 0.1), random_.Uniform(-0.1, 0.1), random_.Uniform(-0.1, 0.1));
      to.direction = (to.direction + turn).normalized();
    }
    seen = BothSee(from, target) && BothSee(to, target) && to.at_m.z() > 0.75 * ride.nearest_m;
  }
  ADIT_REQUIRE(seen);
  seconds_ = ride.seconds;
  sim::SceneTarget placed;
  placed.target = target;
  placed.motion = Between(from, to);
  const double middle_m = (0.5 * (from.at_m + to.at_m)).norm();
  placed.surface_dn =
      sim::SurfaceOfPeak(random_.Uniform(ride.peak_min_dn, ride.peak_max_dn),
                         kFocalPx * target.led_diameter_m / 2 / middle_m, scene_.sensor.psf_sigma_px);
  scene_.targets.push_back(std::move(placed));
}

void Tunnel::Hide(std::size_t target, std::size_t led, int side, const sim::Interval& when) {
  constexpr double kBeforeM = 0.6;  // from the LED towards the eye: the other eye sees past
  constexpr double kPlateM = 0.09;
  constexpr int kLegs = 8;
  // The target stands still before its ride and after it; the plate must follow it during it.
  const double from_s = std::max(when.from_s, 0.0), to_s = std::min(when.to_s, seconds_);
  const Vector3d right_eye_m = scene_.rig.T_r_l.Inverse().translation_m;
  const sim::SceneTarget& bar = scene_.targets[target];
  for (int eye = 0; eye < 2; ++eye) {
    if (side != 2 && side != eye) continue;
    const Vector3d eye_m = eye == 0 ? Vector3d(Vector3d::Zero()) : right_eye_m;
    sim::Course course;
    for (int i = 0; i <= kLegs; ++i) {
      const double t_s = from_s + (to_s - from_s) * i / kLegs;
      const Vector3d led_m = bar.motion->At(t_s) * (bar.led1_m + bar.target.leds_m[led] * bar.direction);
      course.waypoints.push_back({t_s, led_m + kBeforeM * (eye_m - led_m).normalized(), Vector3d::UnitX()});
    }
    sim::Occluder plate;
    plate.motion = sim::MakePath(course, {});
    plate.width_m = plate.height_m = kPlateM;
    plate.active = when;
    scene_.occluders.push_back(std::move(plate));
  }
}

void Tunnel::HideAll(std::size_t target, const sim::Interval& when) {
  for (std::size_t led = 0; led < base::kLedCount; ++led) Hide(target, led, 2, when);
}

void Tunnel::AddLamps(int count, double diameter_max_m) {
  for (int i = 0; i < count; ++i) {
    sim::Light lamp;
    lamp.motion = Still();
    lamp.place_m = DrawInView(15, 180);
    lamp.diameter_m = random_.Uniform(0.03, diameter_max_m);
    lamp.surface_dn = 60 * std::pow(50, random_.Uniform());
    scene_.lamps.push_back(std::move(lamp));
  }
}

void Tunnel::AddCollinear(std::size_t target, int count) {
  const sim::SceneTarget& bar = scene_.targets[target];
  const auto pose = bar.motion->At(0.5 * seconds_);
  for (int i = 0; i < count; ++i) {
    sim::Light lamp;
    lamp.motion = bar.motion;
    const double along_m = random_.Uniform(-1.2, bar.target.LengthM() + 1.2);
    lamp.place_m = bar.led1_m + along_m * bar.direction;
    if (i % 2 == 1) {
      const Vector3d on_line_m = pose * lamp.place_m;  // seen from the left eye, the rig's origin
      lamp.place_m = pose.Inverse() * (random_.Uniform(0.6, 1.6) * on_line_m);
    }
    lamp.diameter_m = bar.target.led_diameter_m;
    lamp.surface_dn = bar.surface_dn * random_.Uniform(0.5, 2);
    scene_.lamps.push_back(std::move(lamp));
  }
}

void Tunnel::AddRow(int count) {
  const Vector3d start_m = DrawInView(20, 90);
  const double step_m = 0.3 * std::pow(30, random_.Uniform());
  const Vector3d direction =
      Vector3d(random_.Uniform(-0.1, 0.1), random_.Uniform(-0.1, 0.1), random_.Uniform() < 0.5 ? 0.3 : 1)
          .normalized();
  const double diameter_m = random_.Uniform(0.04, 0.2), surface_dn = 100 * std::pow(20, random_.Uniform());
  for (int i = 0; i < count; ++i) {
    sim::Light lamp;
    lamp.motion = Still();
    lamp.place_m = start_m + i * step_m * direction;
    lamp.diameter_m = diameter_m;
    lamp.surface_dn = surface_dn;
    scene_.lamps.push_back(std::move(lamp));
  }
}

void Tunnel::AddHeadlights(double seconds) {
  const Vector3d from_m = DrawInView(40, 130);
  const Vector3d to_m = from_m - Vector3d(0, 0, random_.Uniform(0, 15) * seconds / 2);
  const auto motion = Between({0, from_m, Vector3d::UnitX()}, {seconds, to_m, Vector3d::UnitX()});
  const double half_m = random_.Uniform(0.5, 1.0), up_m = random_.Uniform(0.8, 1.6);
  const double surface_dn = random_.Uniform(800, 4000);
  for (const auto& [x_m, y_m, diameter_m] :
       {std::array{-half_m, 0.0, 0.18}, std::array{half_m, 0.0, 0.18}, std::array{-0.6 * half_m, -up_m, 0.1},
        std::array{0.6 * half_m, -up_m, 0.1}}) {
    sim::Light lamp;
    lamp.motion = motion;
    lamp.place_m = {x_m, y_m, 0};
    lamp.diameter_m = diameter_m;
    lamp.surface_dn = surface_dn;
    scene_.lamps.push_back(std::move(lamp));
  }
}

void Tunnel::AddWater(double reflectivity, double wobble_rad) {
  // Just below the lowest light.
  double lowest_m = 0.5;
  for (const sim::SceneTarget& target : scene_.targets) {
    for (const double t_s : {0.0, seconds_}) {
      for (const double led_m : target.target.leds_m)
        lowest_m =
            std::max(lowest_m, (target.motion->At(t_s) * (target.led1_m + led_m * target.direction)).y());
    }
  }
  scene_.water = sim::Water{lowest_m + random_.Uniform(0.1, 1.0), 0, 1000, reflectivity, wobble_rad};
}

}  // namespace adit::host
