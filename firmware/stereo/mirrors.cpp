#include "firmware/stereo/mirrors.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

using base::kLedCount;
using Eigen::Vector3d;

namespace {

double SigmaM(const Solution& s) { return std::sqrt(s.points.epicenter_covariance_m2.trace()); }

/// The plane that mirrors one place of a target into another as well as a plane can.
struct MirrorFit {
  Vector3d normal = Vector3d::Zero();  ///< unit, from the first to the second
  Vector3d on_plane_m = Vector3d::Zero();
  double separation_m = 0;  ///< of the two places
  double residual_m = 0;    ///< of the LED that fits worst
};

MirrorFit FitMirror(const Solution& real, const Solution& image) {
  MirrorFit fit;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    fit.normal += image.points.leds_b_m[i] - real.points.leds_b_m[i];
    fit.on_plane_m += (image.points.leds_b_m[i] + real.points.leds_b_m[i]) / (2 * kLedCount);
  }
  fit.separation_m = fit.normal.norm() / kLedCount;
  fit.normal.normalize();
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const Vector3d& p = real.points.leds_b_m[i];
    const Vector3d mirrored = p + 2 * fit.normal.dot(fit.on_plane_m - p) * fit.normal;
    fit.residual_m = std::max(fit.residual_m, (mirrored - image.points.leds_b_m[i]).norm());
  }
  return fit;
}

double MirrorWithinM(const Solution& real, const Solution& image, const MirrorFit& fit,
                     const LocatorOptions& options) {
  constexpr double kWaviness = 0.01;  // of the separation: surfaces that still show an image are this flat
  return SameWithinM(real, image, options) + kWaviness * fit.separation_m;
}

/// Places farther from where a mirror showed are not said to be behind it.
constexpr double kReachM = 60;

}  // namespace

double SameWithinM(const Solution& a, const Solution& b, const LocatorOptions& options) {
  constexpr double kSameM = 0.010;  // a position 10 mm off harms nobody
  return kSameM + options.sigmas * (SigmaM(a) + SigmaM(b));
}

bool MayBeMirrorImage(const LocatorOptions& options, const Solution& place, const Solution& image) {
  const MirrorFit fit = FitMirror(place, image);
  return fit.residual_m <= MirrorWithinM(place, image, fit, options);
}

void Mirrors::Set(base::TimeNs exposure_ns) {
  exposure_ns_ = exposure_ns;
  constexpr base::DurationNs kForgottenNs = 60 * base::kNsPerS;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    // A clock that stepped back says nothing about the water.
    if (exposure_ns - planes_[i].seen_ns <= kForgottenNs) planes_[kept++] = planes_[i];
  }
  planes_.Truncate(kept);
}

bool Mirrors::IsImage(const Solution& real, const Solution& image) const {
  const MirrorFit fit = FitMirror(real, image);
  const double within_m = MirrorWithinM(real, image, fit, options_);
  if (!(fit.separation_m > 2 * within_m) || image.flux_dn > kMirrorDimmer * real.flux_dn) return false;
  for (const View& view : views_) {
    if (fit.normal.dot(view.CentreM() - fit.on_plane_m) >= 0) return false;
  }
  return fit.residual_m <= within_m;
}

void Mirrors::Remember(const Solution& real, const Solution& image) {
  // Two bars over one water tell its plane alike within this.
  constexpr double kSameRad = 0.02, kSameM = 0.05;
  const MirrorFit fit = FitMirror(real, image);
  const double weight_m2 = fit.separation_m * fit.separation_m;
  for (Plane& plane : planes_) {
    const double aside_m = (fit.on_plane_m - plane.on_plane_m).norm();
    if ((plane.normal - fit.normal).norm() > kSameRad || aside_m > kReachM) continue;
    if (std::abs(plane.normal.dot(fit.on_plane_m - plane.on_plane_m)) > kSameM + kSameRad * aside_m) continue;
    constexpr double kMemory = 100;  // sightings; water rises and falls
    const double share = weight_m2 / (plane.weight_m2 + weight_m2);
    plane.normal = (plane.normal + share * (fit.normal - plane.normal)).normalized();
    plane.on_plane_m += share * (fit.on_plane_m - plane.on_plane_m);
    plane.weight_m2 = std::min(plane.weight_m2 + weight_m2, kMemory * weight_m2);
    plane.seen_ns = exposure_ns_;
    return;
  }
  // Without room the oldest goes.
  if (planes_.Full()) {
    auto* const oldest = std::min_element(
        planes_.begin(), planes_.end(), [](const Plane& a, const Plane& b) { return a.seen_ns < b.seen_ns; });
    *oldest = planes_[planes_.size() - 1];
    planes_.Truncate(planes_.size() - 1);
  }
  planes_.push_back({fit.normal, fit.on_plane_m, weight_m2, exposure_ns_});
}

bool Mirrors::IsBehind(const Solution& place) const {
  constexpr double kLevelRad = 0.003;  // how well a few pairs tell the normal
  constexpr double kDeepM = 0.05;
  return std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
    const auto& leds_m = place.points.leds_b_m;
    return std::all_of(leds_m.begin(), leds_m.end(), [&](const Vector3d& led_m) {
      const double deep_m = plane.normal.dot(led_m - plane.on_plane_m);
      const double above_m = plane.normal.dot(plane.on_plane_m - views_[0].CentreM());
      // Where the line of sight passes the plane.
      const Vector3d pass_m = led_m + deep_m / (deep_m + above_m) * (views_[0].CentreM() - led_m);
      const double aside_m = (pass_m - plane.on_plane_m).norm();
      return aside_m <= kReachM && deep_m > kDeepM + kLevelRad * aside_m;
    });
  });
}

}  // namespace adit::stereo
