#include "firmware/watch/bar_view.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "firmware/base/symmetric.h"

namespace adit::watch {

using base::kLedCount;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr int kBarParameters = 5, kCoordinates = 4 * kLedCount;
/// What a single view may call a motion of the camera before it is judged as a wrong match: 1 px of rotation
/// and 1 cm of the centre. Wide; it only keeps the normal matrix regular.
constexpr double kWidestTurnRad = 3e-4, kWidestShiftM = 0.01;

/// Less than this is not told from noise, and is as good as standing.
constexpr double kLeastMovePx = 0.02;

Vector3d LedPoint(const base::Target& target, const Vector3d& epicenter_b_m, const Vector3d& direction_b,
                  std::size_t led) {
  return epicenter_b_m + (target.leds_m[led] - target.epicenter_m) * direction_b;
}

/// The whitened residuals of a bar and their derivatives.
struct Linearised {
  Eigen::Matrix<double, kCoordinates, 1> residuals;
  Eigen::Matrix<double, kCoordinates, kBarParameters> by_bar;
  Eigen::Matrix<double, kCoordinates, 6> by_motion = Eigen::Matrix<double, kCoordinates, 6>::Zero();
};

}  // namespace

bool BarView::Add(const stereo::Views& views, const base::Target& target, const stereo::PointSet& set,
                  const stereo::TargetPoints& points) {
  const std::array<const detect::BlobSet*, 2> images{set.left->blob_set, set.right->blob_set};
  LedSums pair;
  std::array<Vector2d, 2> first_px{Vector2d::Zero(), Vector2d::Zero()};
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const Vector3d point_b_m = LedPoint(target, points.epicenter_b_m, points.direction_b, i);
    for (std::size_t s = 0; s < 2; ++s) {
      const std::size_t index = points.blobs[s][i];
      Vector2d seen_px;
      Eigen::Matrix<double, 2, 3> slope;
      if (index >= images[s]->blobs.size() || !views[s].Project(point_b_m, seen_px, slope)) return false;
      const detect::Blob& blob = images[s]->blobs[index];
      pair[i][s] = {seen_px - blob.ideal_px, blob.covariance_px2};
      if (i == 0) first_px[s] = blob.ideal_px;
    }
  }
  for (std::size_t i = 0; i < kLedCount; ++i) {
    for (std::size_t s = 0; s < 2; ++s) {
      if (pairs_ == 0) {
        sums_[i][s] = pair[i][s];
      } else {
        sums_[i][s].px += pair[i][s].px;
        sums_[i][s].covariance_px2 += pair[i][s].covariance_px2;
      }
    }
  }
  if (pairs_ == 0) start_px_ = first_px;
  epicenter_b_m_ = points.epicenter_b_m, direction_b_ = points.direction_b;
  pairs_ += 1;
  return true;
}

double BarView::MoveTo(const stereo::PointSet& set, const stereo::TargetPoints& points) {
  const std::array<const detect::BlobSet*, 2> images{set.left->blob_set, set.right->blob_set};
  double moved_px = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    const std::size_t index = points.blobs[s][0];
    if (pairs_ == 0 || index >= images[s]->blobs.size()) return 0;
    last_px_[s] = images[s]->blobs[index].ideal_px;
    moved_px = std::max(moved_px, (last_px_[s] - start_px_[s]).norm());
  }
  return moved_px;
}

std::optional<Information> BarView::Read(const stereo::Views& views, const base::Target& target,
                                         double bias_px, double chi_square_max) const {
  if (pairs_ == 0) return std::nullopt;
  // The image in which a coordinate moved less decides.
  const Vector2d moved_px =
      (last_px_[0] - start_px_[0]).cwiseAbs().cwiseMin((last_px_[1] - start_px_[1]).cwiseAbs());
  const Vector2d bias_px2 = bias_px * bias_px * moved_px.cwiseMax(kLeastMovePx).cwiseMin(1).cwiseInverse();
  Linearised all;
  Eigen::Matrix<double, 3, 2> tangent;
  tangent.col(0) = direction_b_.unitOrthogonal();
  tangent.col(1) = direction_b_.cross(tangent.col(0));
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const Vector3d point_b_m = LedPoint(target, epicenter_b_m_, direction_b_, i);
    for (std::size_t s = 0; s < 2; ++s) {
      const auto row = static_cast<Eigen::Index>(4 * i + 2 * s);
      Vector2d seen_px;
      Eigen::Matrix<double, 2, 3> slope;
      if (!views[s].Project(point_b_m, seen_px, slope)) return std::nullopt;
      // Of a mean of n: a sum of n covariances / n^2.
      const stereo::Observation mean{sums_[i][s].px / pairs_, sums_[i][s].covariance_px2 / (pairs_ * pairs_)};
      const stereo::Observation biased{mean.px, mean.covariance_px2 + Eigen::Matrix2d(bias_px2.asDiagonal())};
      const Eigen::Matrix2d w = biased.Whitener(0);
      const Eigen::Matrix<double, 2, 3> by_point = w * slope;
      all.residuals.segment<2>(row) = w * mean.px;
      all.by_bar.block<2, 3>(row, 0) = by_point;
      all.by_bar.block<2, 2>(row, 3) = (target.leds_m[i] - target.epicenter_m) * by_point * tangent;
      if (s == 0) continue;
      // In the right camera's frame a point moves by rotation x p; slope is by the point in b.
      const Vector3d arm_m = views[1].rotation * point_b_m + views[1].translation_m;
      all.by_motion.block<2, 3>(row, 0) = -by_point * views[1].rotation.transpose() * base::Skew(arm_m);
      all.by_motion.block<2, 3>(row, 3) = -by_point;
    }
  }
  // Schur complement of the bar's parameters. lazyProduct: as in stereo, for factors this small.
  const Eigen::Matrix<double, kBarParameters, kBarParameters> bar =
      all.by_bar.transpose().lazyProduct(all.by_bar);
  const Eigen::Matrix<double, kBarParameters, 6> mixed = all.by_bar.transpose().lazyProduct(all.by_motion);
  const Eigen::Matrix<double, kBarParameters, 1> bar_gradient = all.by_bar.transpose() * all.residuals;
  const Eigen::Matrix<double, kBarParameters, kBarParameters> inverse = base::InverseSymmetric(bar);
  if (!inverse.allFinite()) return std::nullopt;
  const Eigen::Matrix<double, kBarParameters, 6> pulled = inverse.lazyProduct(mixed);
  Information information;
  information.normal = all.by_motion.transpose().lazyProduct(all.by_motion);
  information.normal -= mixed.transpose().lazyProduct(pulled);
  // seen + J x - measured = noise: the residuals' own gradient changes its sign.
  information.gradient = pulled.transpose() * bar_gradient - all.by_motion.transpose() * all.residuals;
  information.chi_square = all.residuals.squaredNorm() - bar_gradient.dot(inverse * bar_gradient);
  information.redundancy = kCoordinates - kBarParameters;
  MotionMatrix wide = information.normal;
  wide.diagonal().head<3>().array() += 1 / (kWidestTurnRad * kWidestTurnRad);
  wide.diagonal().tail<3>().array() += 1 / (kWidestShiftM * kWidestShiftM);
  const double explained = base::MahalanobisSquared(wide, information.gradient);
  if (!(information.chi_square - explained <= chi_square_max)) return std::nullopt;
  return information;
}

}  // namespace adit::watch
