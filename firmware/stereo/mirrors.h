// Reflections in water, wet walls and glass: which place is one, and of which the mirrors are known.
#pragma once

#include "firmware/base/fixed_vector.h"
#include "firmware/stereo/solution.h"

namespace adit::stereo {

/// A mirror does not amplify; a fifth for angle and noise.
inline constexpr double kMirrorDimmer = 1.2;

/// How far two places of a target may differ and still be one.
double SameWithinM(const Solution& a, const Solution& b, const LocatorOptions& options);

/// Whether `image` can be the reflection of the target at `place` in any plane; places that may be one and
/// the same can.
bool MayBeMirrorImage(const LocatorOptions& options, const Solution& place, const Solution& image);

/// The mirrors in view. A target and its reflection, seen together, tell the plane, and it is the same for
/// every target: what stands behind it afterwards is a reflection, also while the target itself is hidden. A
/// reflection whose mirror was never seen so cannot be told from a target, unless two of its lights are seen
/// themselves (ReflectsLights). One thread; no allocation.
class Mirrors {
 public:
  Mirrors(const optics::Rig& rig, const LocatorOptions& options)
      : views_(MakeViews(rig)), options_(options) {}

  /// The exposure of the pair that is being located. A mirror that showed nothing for a minute is forgotten:
  /// the water may have been pumped off.
  void Set(base::TimeNs exposure_ns);

  /// Whether `image` is `real` seen in a plane mirror: every LED moved along the plane's normal by twice its
  /// distance from the plane, real on the cameras' side, and no brighter.
  bool IsImage(const Solution& real, const Solution& image) const;

  /// Takes the plane of a target and its reflection.
  void Remember(const Solution& real, const Solution& image);

  /// Whether a place is behind a mirror, seen from the cameras, and its line of sight passes the plane not
  /// too far from where it showed: puddles end.
  bool IsBehind(const Solution& place) const;

 private:
  struct Plane {
    Eigen::Vector3d normal, on_plane_m;  ///< unit, away from the cameras
    double weight_m2 = 0;                ///< the farther the reflection, the better it tells the plane
    base::TimeNs seen_ns = base::kNever;
  };
  static constexpr std::size_t kMaxPlanes = 16;

  Views views_;
  LocatorOptions options_;
  base::TimeNs exposure_ns_ = base::kNever;
  base::FixedVector<Plane, kMaxPlanes> planes_;
};

}  // namespace adit::stereo
