// Scenes underground, drawn at random: what the campaigns look at.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/sim/random.h"
#include "drivers/sim/scene.h"
#include "firmware/identify/model.h"

namespace adit::host {

/// The bars that the campaigns carry: two of 1.5 m, and a short one with its epicenter at a tip 0.38 m beyond
/// LED 4. With any one LED hidden, and read from either end, the gaps of any two still differ by 7 cm.
std::vector<base::Target> TunnelTargets();
/// Models from geometry for the campaigns' cameras.
std::vector<identify::Model> ModelsOf(const std::vector<base::Target>& targets);

/// 1400 x 1024, f = 3378 px, toed in so that the axes meet `converge_m` ahead, the right camera rolled and
/// pitched a little, lenses with 8 px of distortion in the corners.
optics::Rig TunnelRig(double base_m, double converge_m = 35);

/// Draws one scene, piece by piece. Everything follows from the seed.
class Tunnel {
 public:
  Tunnel(std::uint64_t seed, const optics::Rig& rig);

  /// How a target moves.
  struct Ride {
    double nearest_m = 20, farthest_m = 110;
    double speed_max_mps = 5;  ///< along the view; a fifth of it across
    double lean_max = 0.7;     ///< of the direction's z
    double seconds = 1;
    double peak_min_dn = 60, peak_max_dn = 200;  ///< of an LED in the middle of the ride
  };
  /// A bar that both cameras see entirely at both ends of its ride.
  void AddTarget(const base::Target& target, const Ride& ride);
  /// Hides LED `led` (0 to 3) of a target from the left camera (side 0), the right one (1) or both (2) by
  /// plates just before it.
  void Hide(std::size_t target, std::size_t led, int side, const sim::Interval& when);
  /// Hides all LEDs of a target.
  void HideAll(std::size_t target, const sim::Interval& when);
  /// Lamps in the common view, anywhere from 15 to 180 m; no larger than `diameter_max_m`.
  void AddLamps(int count, double diameter_max_m = 0.3);
  /// Lights of an LED's size that move with a target: on the bar's line in space, hence in both images, or
  /// (every second) on its line in the left image only.
  void AddCollinear(std::size_t target, int count);
  /// Lamps at equal distances along a line, as on a tunnel's wall.
  void AddRow(int count);
  /// A vehicle with four lights that comes nearer.
  void AddHeadlights(double seconds);
  void AddWater(double reflectivity, double wobble_rad);

  sim::Random& Draw() { return random_; }
  sim::Scene& Scene() { return scene_; }
  sim::Scene Take() { return std::move(scene_); }

 private:
  sim::Waypoint DrawPlace(double nearest_m, double farthest_m, double lean_max);
  bool BothSee(const sim::Waypoint& place, const base::Target& target) const;
  Eigen::Vector3d DrawInView(double nearest_m, double farthest_m);

  sim::Random random_;
  sim::Scene scene_;
  double seconds_ = 1;
};

}  // namespace adit::host
