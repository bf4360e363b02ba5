#include "drivers/sim/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/sim/projection.h"
#include "drivers/sim/random.h"

namespace adit::sim {
namespace {

using base::Side;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kFaintestFluxDn = 0.05;  // spread over several pixels: far below one DN's rounding

std::array<Vector2d, kDiscPoints> PlaceDiscPoints() {
  std::array<Vector2d, kDiscPoints> points;
  points[0] = Vector2d::Zero();
  std::size_t next = 1, inside = 1;
  for (const int count : {6, 12, 18}) {
    // Each ring stands for its share of the area; its radius halves that area.
    const double radius = std::sqrt((static_cast<double>(inside) + count / 2.0) / kDiscPoints);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * pi * (i + 0.25) / count;  // no two points on one upright or level line
      points[next++] = radius * Vector2d(std::cos(angle), std::sin(angle));
    }
    inside += static_cast<std::size_t>(count);
  }
  return points;
}

/// An opaque rectangle in the rig frame.
struct Plate {
  base::Pose<base::Rig, Mobile> pose;
  Vector3d centre_m;
  double half_width_m, half_height_m;
};

Plate PlateOf(const Occluder& occluder, double t_s) {
  const auto pose = occluder.motion->At(t_s);
  return {pose, pose * occluder.centre_m, occluder.width_m / 2, occluder.height_m / 2};
}

/// By how far the ray from `eye_m` to `point_m` misses the plate, metres in its plane; negative: hits it. The
/// second value is the hit's share of the way.
std::optional<std::pair<double, double>> Miss(const Plate& plate, const Vector3d& eye_m,
                                              const Vector3d& point_m) {
  const Vector3d normal = plate.pose.rotation.col(2);
  const double whole = normal.dot(point_m - eye_m);
  const double part = normal.dot(plate.centre_m - eye_m);
  if (std::abs(whole) < 1e-12) return std::nullopt;
  const double share = part / whole;
  if (share <= 0 || share >= 1) return std::nullopt;  // behind the eye, or beyond the point
  const Vector3d off_m = eye_m + share * (point_m - eye_m) - plate.centre_m;
  return std::pair{std::max(std::abs(plate.pose.rotation.col(0).dot(off_m)) - plate.half_width_m,
                            std::abs(plate.pose.rotation.col(1).dot(off_m)) - plate.half_height_m),
                   share};
}

}  // namespace

const std::array<Vector2d, kDiscPoints>& DiscPoints() {
  static const auto points = PlaceDiscPoints();
  return points;
}

World::World(Scene scene) : scene_(std::move(scene)), painter_(scene_.sensor.psf_sigma_px) {
  for (const SceneTarget& target : scene_.targets) {
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      AddSource({target.motion.get(), target.led1_m + target.target.leds_m[i] * target.direction,
                 target.target.led_diameter_m / 2, target.surface_dn, &target.off[i], false, 0});
    }
  }
  for (const Light& lamp : scene_.lamps) {
    AddSource({lamp.motion.get(), lamp.place_m, lamp.diameter_m / 2, lamp.surface_dn, &lamp.off, false, 0});
  }
  if (!scene_.water) return;
  Random random(scene_.seed, 0x77617465);
  const std::size_t count = lights_.size();
  for (std::size_t i = 0; i < count; ++i) {
    Source image = lights_[i];
    image.mirrored = true;
    image.surface_dn *= scene_.water->reflectivity;
    image.phase_rad = random.Uniform(0, 2 * pi);
    AddSource(image);
  }
}

void World::AddSource(const Source& source) { lights_.push_back(source); }

base::TimeNs World::TriggerNs(std::uint64_t trigger) const {
  return scene_.start_ns + std::llround(static_cast<double>(trigger) / scene_.rate_hz * 1e9);
}

base::TimeNs World::MidExposureNs(std::uint64_t trigger) const {
  return TriggerNs(trigger) + std::llround(scene_.exposure_s / 2 * 1e9);
}

double World::MidExposureS(std::uint64_t trigger) const {
  return static_cast<double>(MidExposureNs(trigger) - scene_.start_ns) * 1e-9;
}

double World::ExposureFactor(double t_s) const {
  if (!scene_.auto_exposure) return 1;
  double peak_dn = 0;
  for (std::size_t i = 0; i < base::kLedCount * scene_.targets.size(); ++i) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const auto seen = Receive(i, side, t_s);
      if (seen && seen->shown == kAllShown) peak_dn = std::max(peak_dn, painter_.Value(seen->disc, 0));
    }
  }
  if (peak_dn <= 0) return 1;
  const AutoExposure& limits = *scene_.auto_exposure;
  return std::clamp(limits.peak_dn / peak_dn, limits.shortest_s / scene_.exposure_s,
                    limits.longest_s / scene_.exposure_s);
}

bool World::AtRest(std::size_t light) const {
  const Source& source = lights_[light];
  return source.motion->AtRest() && !source.mirrored && source.off->empty();
}

Vector3d World::Eye(Side side) const {
  return side == Side::kLeft ? Vector3d::Zero() : scene_.rig.T_r_l.Inverse().translation_m;
}

Vector3d World::PlaceOf(const Source& source, double t_s) const {
  const Vector3d place_m = source.motion->At(t_s) * source.place_m;
  if (!source.mirrored) return place_m;
  const auto T_g_b = scene_.T_b_g.Inverse();
  Vector3d ground_m = T_g_b * place_m;
  ground_m.y() = 2 * scene_.water->y_m - ground_m.y();
  // Ripples tilt the mirror: the image wanders across a cone about its place, more along the view than
  // across.
  constexpr double kRippleHz = 1.7, kAcross = 0.3;
  const double swing = 2 * pi * kRippleHz * t_s + source.phase_rad;
  const double reach_m = scene_.water->wobble_rad * ground_m.norm();
  ground_m.y() += reach_m * std::sin(swing);
  ground_m.x() += kAcross * reach_m * std::sin(1.31 * swing + 1);
  return scene_.T_b_g * ground_m;
}

bool World::MirrorShows(const Vector3d& image_m, const Vector3d& eye_m) const {
  const auto T_g_b = scene_.T_b_g.Inverse();
  const Vector3d eye = T_g_b * eye_m, image = T_g_b * image_m;
  const double share = (scene_.water->y_m - eye.y()) / (image.y() - eye.y());
  if (!(share > 0 && share < 1)) return false;  // the eye or the light is under water
  const double z_m = eye.z() + share * (image.z() - eye.z());
  return z_m >= scene_.water->nearest_m && z_m <= scene_.water->farthest_m;
}

std::uint64_t World::Shown(const Vector3d& centre_m, double radius_m, Side side, double t_s) const {
  const Vector3d eye_m = Eye(side);
  std::uint64_t shown = kAllShown;
  const Eigen::Matrix3d axes = side == Side::kLeft ? Eigen::Matrix3d::Identity()
                                                   : Eigen::Matrix3d(scene_.rig.T_r_l.rotation.transpose());
  for (const Occluder& occluder : scene_.occluders) {
    if (!occluder.active.Holds(t_s)) continue;
    const Plate plate = PlateOf(occluder, t_s);
    const auto centre = Miss(plate, eye_m, centre_m);
    // Far from the rim the centre speaks for all; twice the radius, for the plate may be seen at a slant.
    if (!centre || centre->first > 2 * radius_m * centre->second) continue;
    for (std::size_t i = 0; i < kDiscPoints; ++i) {
      const Vector2d& at = DiscPoints()[i];
      const Vector3d point_m = centre_m + radius_m * (at.x() * axes.col(0) + at.y() * axes.col(1));
      const auto miss = Miss(plate, eye_m, point_m);
      if (miss && miss->first < 0) shown &= ~(std::uint64_t{1} << i);
    }
  }
  return shown;
}

std::optional<Reception> World::Receive(std::size_t light, Side side, double t_s) const {
  const Source& source = lights_[light];
  const bool off = std::any_of(source.off->begin(), source.off->end(),
                               [t_s](const Interval& interval) { return interval.Holds(t_s); });
  if (off) return std::nullopt;
  const optics::CameraModel& camera = Camera(side);
  const Vector3d place_m = PlaceOf(source, t_s);
  const Vector3d eye_m = Eye(side);
  const Vector3d in_camera_m = side == Side::kLeft ? place_m : scene_.rig.T_r_l * place_m;
  const auto px = ProjectPoint(camera, in_camera_m);
  if (!px || (source.mirrored && !MirrorShows(place_m, eye_m))) return std::nullopt;
  Reception seen;
  seen.distance_m = in_camera_m.norm();
  seen.disc.x_px = px->x(), seen.disc.y_px = px->y();
  seen.disc.radius_px = std::sqrt(camera.fu_px * camera.fv_px) * source.radius_m / seen.distance_m;
  const double clear_air = std::exp(-scene_.fog.per_m * seen.distance_m);
  seen.disc.flux_dn = source.surface_dn * clear_air * pi * seen.disc.radius_px * seen.disc.radius_px;
  const double reach_px = painter_.ReachPx(seen.disc.radius_px) +
                          4 * std::max(scene_.sensor.glare_sigma_px * (scene_.sensor.glare > 0 ? 1 : 0),
                                       scene_.fog.glow_sigma_px * (scene_.fog.glow > 0 ? 1 : 0));
  if (seen.disc.flux_dn < kFaintestFluxDn || px->x() < -reach_px || px->y() < -reach_px ||
      px->x() > camera.width_px + reach_px || px->y() > camera.height_px + reach_px)
    return std::nullopt;
  seen.shown = Shown(place_m, source.radius_m, side, t_s);
  return seen;
}

}  // namespace adit::sim
