#include "firmware/stereo/reflected_lights.h"

#include <algorithm>
#include <cmath>

#include "firmware/stereo/mirrors.h"

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Nearer lights stand beside the bar or are its own: a bar hangs above the water.
constexpr double kNearestLightM = 0.2;
/// An LED is seen along two ways that leave it at an angle of 60 degrees at most: LEDs shine forwards.
constexpr double kCosineMin = 0.5;
/// LEDs of one bar, in one mirror.
constexpr float kAlikeMirrored = 1.25F;
/// Of the distance between a light and its reflection: by how much waves move two LEDs differently, twice
/// what those of half a milliradian do. Rougher water shows no rigid bar.
constexpr double kUneven = 0.001;

/// A plane between a light and its reflection.
struct Plane {
  Vector3d normal, on_plane_m;  ///< unit, towards the reflection

  Vector3d Mirrored(const Vector3d& point_m) const {
    return point_m - 2 * normal.dot(point_m - on_plane_m) * normal;
  }
};

/// One bar among the lights of one pair.
class Search {
 public:
  Search(const Solution& bar, const PointCloud& cloud, const detect::BlobSet& left,
         const LocatorOptions& options)
      : bar_(bar), cloud_(cloud), left_(left), options_(options) {
    for (const std::uint16_t blob : bar.points.blobs[0]) {
      if (blob != kNoBlob)
        noise_px_ = std::max(noise_px_, std::sqrt(left.blobs[blob].covariance_px2.trace() / 2));
    }
  }

  /// Whether a light is none of the bar's, and bright enough to be what it reflects.
  bool MayBeReal(const CloudPoint& light) const {
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& taken = bar_.points.blobs[side];
      if (std::find(taken.begin(), taken.end(), light.blobs[side]) != taken.end()) return false;
    }
    return FluxDn(light) * kMirrorDimmer >= bar_.flux_dn;
  }

  /// Whether the plane that makes LED `led` of `light` makes a later LED of another light.
  bool MirrorsTwo(const CloudPoint& light, std::size_t led) const {
    const auto& leds_m = bar_.points.leds_b_m;
    const double separation_m = (leds_m[led] - light.point_b_m).norm();
    if (!(separation_m > kNearestLightM)) return false;
    const Plane plane{(leds_m[led] - light.point_b_m) / separation_m, 0.5 * (leds_m[led] + light.point_b_m)};
    if (!IsSeenFrom(plane, light)) return false;
    const double reach_px = options_.sigmas * 2 * std::max(light.noise_px, noise_px_) +
                            kUneven * separation_m * cloud_.GetViews()[0].fu_px / light.depth_m[0];
    for (std::size_t i = led + 1; i < kLedCount; ++i) {
      if (HasLightAt(plane.Mirrored(leds_m[i]), light, reach_px)) return true;
    }
    return false;
  }

 private:
  float FluxDn(const CloudPoint& light) const { return left_.blobs[light.blobs[0]].flux_dn; }

  /// Whether both cameras are on the light's side of a mirror and may see it directly and in the mirror.
  bool IsSeenFrom(const Plane& plane, const CloudPoint& light) const {
    const auto sees = [&](const View& view) {
      const Vector3d eye_m = view.CentreM(), to_eye_m = eye_m - light.point_b_m;
      const Vector3d to_mirrored_m = plane.Mirrored(eye_m) - light.point_b_m;
      return plane.normal.dot(eye_m - plane.on_plane_m) < 0 &&
             to_eye_m.dot(to_mirrored_m) > kCosineMin * to_eye_m.norm() * to_mirrored_m.norm();
    };
    return std::all_of(cloud_.GetViews().begin(), cloud_.GetViews().end(), sees);
  }

  /// Whether a light as bright as `first` stands at a place in both images.
  bool HasLightAt(const Vector3d& place_b_m, const CloudPoint& first, double reach_px) const {
    std::array<Vector2d, 2> px;
    Eigen::Matrix<double, 2, 3> slope;
    for (std::size_t side = 0; side < 2; ++side) {
      if (!cloud_.GetViews()[side].Project(place_b_m, px[side], slope)) return false;
    }
    for (std::size_t i = cloud_.FirstFrom(px[0].x() - reach_px);
         i < cloud_.size() && cloud_[i].px[0].x() <= px[0].x() + reach_px; ++i) {
      const CloudPoint& light = cloud_[i];
      bool is_it = MayBeReal(light);
      for (std::size_t side = 0; side < 2; ++side)
        is_it =
            is_it && light.blobs[side] != first.blobs[side] && (light.px[side] - px[side]).norm() <= reach_px;
      const float ratio = FluxDn(light) / FluxDn(first);
      if (is_it && ratio < kAlikeMirrored && ratio * kAlikeMirrored > 1) return true;
    }
    return false;
  }

  const Solution& bar_;
  const PointCloud& cloud_;
  const detect::BlobSet& left_;
  const LocatorOptions& options_;
  double noise_px_ = 0;  ///< of the worst of the bar's centroids
};

}  // namespace

bool ReflectsLights(const Solution& bar, const PointCloud& cloud, const detect::BlobSet& left,
                    const LocatorOptions& options) {
  const Search search(bar, cloud, left, options);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!search.MayBeReal(cloud[i])) continue;
    for (std::size_t led = 0; led + 1 < kLedCount; ++led) {
      if (search.MirrorsTwo(cloud[i], led)) return true;
    }
  }
  return false;
}

}  // namespace adit::stereo
