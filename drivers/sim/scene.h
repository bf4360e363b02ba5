// A tunnel as a scene file describes it.
//
// A scene is YAML. Times are in s from the first trigger, positions in m. DN are of 8 bit whatever the bits
// (12 bit divide the same range finer). Every key has a default unless "required" is said.
//
//   seed: 1              all that is random
//   rate_hz: 60          triggers
//   frames: 600          how many `adit simulate` renders
//   start_s: 1700000000  the first trigger, seconds of the Unix epoch
//   exposure_s: 0.001    the exposure at which the file's brightnesses hold
//   auto_exposure: {peak_dn: 200, shortest_s: 0.0002, longest_s: 0.008}
//                        if given: each exposure is such that the brightest LED peaks there; its middle stays
//   frame: rig           positions are in the rig frame, or `middle`: origin in the middle of the baseline, x
//                        along it to the right, y down, z ahead
//   rig_file: rig.yaml   a calibrated rig, relative to the scene; or
//   rig: {base_m: 9, focal_px: 3378, width_px: 1400, height_px: 1024, converge_m: 35,
//         left:  {distortion: [0, 0, 0, 0], centre_px: [699.5, 511.5]},
//         right: {distortion: ..., centre_px: ..., roll_deg: 0, pitch_deg: 0}}
//   sensor: {bits: 8, background_dn: 6, read_noise_dn: 1.5, electrons_per_dn: 40, psf_sigma_px: 1.3,
//            glare: 0, glare_sigma_px: 12}     glare: share of a light's flux that the lens spreads widely
//   fog: {per_m: 0, veil_dn: 0, glow: 0, glow_sigma_px: 30}
//                        light fades by exp(-per_m distance); `glow` of what is lost comes back as an
//                        aureole; the veil is added everywhere
//   targets:             a list; each has
//     file: bar.yaml     or, in place: name (required), leds_m (required), epicenter_m, led_diameter_m
//     peak_dn: 200, reference_m: 30      brightness: the peak of an LED at that distance, without fog
//     at_m, direction    LED 1 and the direction of LED 4, at rest; or
//     path: {curve: linear|spline, repeat: false, waypoints: [{t_s:, at_m:, direction: [1, 0, 0]}]}; or
//     wave: {nearest_m: 15, farthest_m: 30, lean_max: 0.7, step_s: 1.5}      see motion.h
//     off: [{led: 2, from_s: 1, to_s: 3}]
//   machines:            a list; things that move together; at_m and direction below are then the machine's
//     drive: {from_m:, to_m:, duration_s:, weave_m: 0, weave_period_s: 10, vibration_m: 0, vibration_hz: 20}
//                        or path, or at_m
//     targets, lamps, hull: {at_m:, width_m:, height_m:}      the hull is an opaque rectangle across z
//   lamps:               a list; each {at_m:, diameter_m: 0.2, surface_dn: 1000, off: [{from_s:, to_s:}]};
//                        surface_dn is the brightness of its disc in the image, however high; or `path`
//   tunnel_lamps: {count:, nearest_m: 15, farthest_m: 150, half_width_m: 5, height_m: 3,
//                  diameter_m: [0.05, 0.3], surface_dn: [100, 3000]}    along walls and crown, by the seed
//   occluders:           a list of opaque rectangles across z: {at_m: or path:, width_m:, height_m:,
//                        from_s:, to_s:}
//   water: {y_m:, nearest_m: 0, farthest_m: 1000, reflectivity: 0.1, wobble_rad: 0.01}
//                        a mirror at that y of the ground frame, between those z, that ripples
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sim/motion.h"
#include "firmware/base/result.h"
#include "firmware/base/target.h"
#include "firmware/base/time.h"
#include "firmware/optics/rig.h"

namespace adit::sim {

struct Interval {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
  bool Holds(double t_s) const { return t_s >= from_s && t_s < to_s; }
};

struct Sensor {
  int bits = 8;
  double background_dn = 6, read_noise_dn = 1.5, electrons_per_dn = 40;
  double psf_sigma_px = 1.3;
  double glare = 0, glare_sigma_px = 12;
};

struct Fog {
  double per_m = 0, veil_dn = 0;
  double glow = 0, glow_sigma_px = 30;
};

struct AutoExposure {
  double peak_dn = 200, shortest_s = 0.0002, longest_s = 0.008;
};

/// A sphere that shines.
struct Light {
  MotionPtr motion;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< in the motion's frame
  double diameter_m = 0.2;
  double surface_dn = 1000;  ///< of its disc in the image at the scene's exposure_s, unclipped
  std::vector<Interval> off;
};

/// A bar. Its LEDs stand at led1_m + leds_m[i] * direction.
struct SceneTarget {
  base::Target target;
  MotionPtr motion;
  Eigen::Vector3d led1_m = Eigen::Vector3d::Zero();        ///< in the motion's frame
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();    ///< likewise, a unit vector
  double surface_dn = 0;                                   ///< as in Light
  std::array<std::vector<Interval>, base::kLedCount> off;  ///< per LED
};

/// An opaque rectangle along x and y of its motion's frame.
struct Occluder {
  MotionPtr motion;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double width_m = 0, height_m = 0;
  Interval active;
};

/// A mirror y = y_m in the ground frame.
struct Water {
  double y_m = 0, nearest_m = 0, farthest_m = 1000;
  double reflectivity = 0.1, wobble_rad = 0.01;
};

struct Scene {
  std::string name;  ///< the file's
  std::uint64_t seed = 1;
  double rate_hz = 60;
  long frames = 600;
  base::TimeNs start_ns = 1'700'000'000'000'000'000;
  double exposure_s = 0.001;
  std::optional<AutoExposure> auto_exposure;
  optics::Rig rig;
  base::Pose<base::Rig, Ground> T_b_g;
  Sensor sensor;
  Fog fog;
  std::vector<SceneTarget> targets;
  std::vector<Light> lamps;
  std::vector<Occluder> occluders;
  std::optional<Water> water;
};

/// Reads a scene and the files that it names; `seed` replaces the file's. Every mistake is one line: file,
/// key, value, what is allowed.
base::Result<Scene> LoadScene(const std::string& path, std::optional<std::uint64_t> seed = std::nullopt);

/// The brightness of a disc's surface such that its image, blurred by the PSF, peaks at `peak_dn`.
double SurfaceOfPeak(double peak_dn, double radius_px, double psf_sigma_px);

}  // namespace adit::sim
