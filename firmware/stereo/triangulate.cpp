#include "firmware/stereo/triangulate.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "firmware/base/symmetric.h"

namespace adit::stereo {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// How far the two rays pass each other, as the volume that base and rays span, by the four coordinates.
struct Miss {
  double volume;
  std::array<Vector2d, 2> slope;
};

Miss MissOf(const Views& views, const Vector3d& base_m, const std::array<Vector2d, 2>& px) {
  const Vector3d a = views[0].Ray(px[0]), b = views[1].Ray(px[1]);
  const Vector3d by_a = b.cross(base_m), by_b = base_m.cross(a);
  const auto by_px = [](const View& view, const Vector3d& by_ray) {
    return Vector2d(view.rotation.row(0).dot(by_ray) / view.fu_px,
                    view.rotation.row(1).dot(by_ray) / view.fv_px);
  };
  return {a.dot(by_a), {by_px(views[0], by_a), by_px(views[1], by_b)}};
}

/// The centroids whose rays meet, nearest to the measured ones by their covariances.
std::optional<std::array<Vector2d, 2>> Corrected(const Views& views, const ObservationPair& pair) {
  constexpr int kStepsMax = 10;
  constexpr double kShortStep = 1e-8;  // squared, in standard deviations
  const Vector3d base_m = views[1].CentreM() - views[0].CentreM();
  std::array<Vector2d, 2> px{pair[0].px, pair[1].px};
  double before = 0;
  for (int i = 0; i < kStepsMax; ++i) {
    const Miss miss = MissOf(views, base_m, px);
    std::array<Vector2d, 2> along;  // the covariances times the slopes
    double variance = 0, volume = miss.volume;
    for (std::size_t s = 0; s < 2; ++s) {
      along[s] = pair[s].covariance_px2 * miss.slope[s] + kNoiseMinPx * kNoiseMinPx * miss.slope[s];
      variance += miss.slope[s].dot(along[s]);
      volume += miss.slope[s].dot(pair[s].px - px[s]);
    }
    // Written so that NaN declines.
    if (!(variance > 0)) return std::nullopt;
    const double move = volume / variance;
    for (std::size_t s = 0; s < 2; ++s) px[s] = pair[s].px - move * along[s];
    const double deviations = volume * move;
    if (std::abs(deviations - before) < kShortStep) return px;
    before = deviations;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vector3d> Midpoint(const Views& views, const Vector2d& left_px, const Vector2d& right_px) {
  const Vector3d a = views[0].Ray(left_px), b = views[1].Ray(right_px);
  const Vector3d base_m = views[1].CentreM() - views[0].CentreM();
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double det = aa * bb - ab * ab;
  constexpr double kParallel = 1e-12;  // sin^2 of a microradian
  if (!(det > kParallel * aa * bb)) return std::nullopt;
  const double ra = (bb * a.dot(base_m) - ab * b.dot(base_m)) / det;
  const double rb = (ab * a.dot(base_m) - aa * b.dot(base_m)) / det;
  return views[0].CentreM() + 0.5 * (ra * a + base_m + rb * b);
}

std::optional<LocatedPoint> LocatedAt(const Views& views, const ObservationPair& pair,
                                      const Vector3d& point_b_m, double floor_px) {
  Eigen::Matrix<double, 4, 3> jacobian;
  for (std::size_t s = 0; s < 2; ++s) {
    Vector2d px;
    Eigen::Matrix<double, 2, 3> slope;
    if (!views[s].Project(point_b_m, px, slope)) return std::nullopt;
    jacobian.middleRows<2>(2 * static_cast<Eigen::Index>(s)) = pair[s].Whitener(floor_px).lazyProduct(slope);
  }
  LocatedPoint located{point_b_m, base::Normal(jacobian).inverse()};
  const double limit_m2 = kDepthSigmaMax * kDepthSigmaMax * point_b_m.squaredNorm();
  // The trace bounds the variance in every direction; written so that NaN declines.
  const double variance_m2 = located.covariance_m2.trace();
  if (!(variance_m2 >= 0 && variance_m2 <= limit_m2)) return std::nullopt;
  return located;
}

std::optional<LocatedPoint> Triangulate(const Views& views, const ObservationPair& pair) {
  const auto px = Corrected(views, pair);
  const auto point_m = px ? Midpoint(views, (*px)[0], (*px)[1]) : std::nullopt;
  return point_m ? LocatedAt(views, pair, *point_m) : std::nullopt;
}

std::optional<LocatedPoint> TriangulateMidpoint(const Views& views, const ObservationPair& pair,
                                                double floor_px) {
  const auto point_m = Midpoint(views, pair[0].px, pair[1].px);
  return point_m ? LocatedAt(views, pair, *point_m, floor_px) : std::nullopt;
}

}  // namespace adit::stereo
