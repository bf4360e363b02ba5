#include "firmware/stereo/triangulate.h"

#include <Eigen/LU>
#include <cmath>

#include "firmware/stereo/levenberg_marquardt.h"

namespace adit::stereo {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Four whitened reprojection residuals of one point.
struct PointProblem {
  static constexpr int kParameters = 3, kResiduals = 4;
  using State = Vector3d;
  const Views* views;
  std::array<Eigen::Vector2d, 2> px;
  std::array<Eigen::Matrix2d, 2> whiteners;

  PointProblem(const Views& both, const ObservationPair& pair, double floor_px)
      : views(&both),
        px{pair[0].px, pair[1].px},
        whiteners{pair[0].Whitener(floor_px), pair[1].Whitener(floor_px)} {}

  bool Evaluate(const State& point_m, Eigen::Vector4d& residuals,
                Eigen::Matrix<double, 4, 3>& jacobian) const {
    for (int side = 0; side < 2; ++side) {
      const auto s = static_cast<std::size_t>(side);
      Eigen::Vector2d seen;
      Eigen::Matrix<double, 2, 3> slope;
      if (!(*views)[s].Project(point_m, seen, slope)) return false;
      residuals.segment<2>(2 * side) = whiteners[s] * (seen - px[s]);
      jacobian.middleRows<2>(2 * side) = whiteners[s] * slope;
    }
    return true;
  }
  State Moved(const State& point_m, const Vector3d& step) const { return point_m + step; }
};

std::optional<LocatedPoint> WithCovariance(const Vector3d& point_m, const Matrix3d& information) {
  LocatedPoint located{point_m, information.inverse()};
  const double distance_m = point_m.norm();
  const double limit_m2 = kDepthSigmaMax * kDepthSigmaMax * distance_m * distance_m;
  // The trace bounds the variance in every direction; written so that NaN declines.
  const double variance_m2 = located.covariance_m2.trace();
  if (!(variance_m2 >= 0 && variance_m2 <= limit_m2)) return std::nullopt;
  return located;
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

std::optional<LocatedPoint> Triangulate(const Views& views, const ObservationPair& pair, double floor_px) {
  const auto start = Midpoint(views, pair[0].px, pair[1].px);
  if (!start) return std::nullopt;
  Vector3d point_m = *start;
  const auto minimum = Minimise(PointProblem(views, pair, floor_px), point_m);
  if (!minimum.converged) return std::nullopt;
  return WithCovariance(point_m, minimum.information);
}

std::optional<LocatedPoint> TriangulateMidpoint(const Views& views, const ObservationPair& pair,
                                                double floor_px) {
  const auto point_m = Midpoint(views, pair[0].px, pair[1].px);
  if (!point_m) return std::nullopt;
  Eigen::Vector4d residuals;
  Eigen::Matrix<double, 4, 3> jacobian;
  if (!PointProblem(views, pair, floor_px).Evaluate(*point_m, residuals, jacobian)) return std::nullopt;
  return WithCovariance(*point_m, jacobian.transpose() * jacobian);
}

}  // namespace adit::stereo
