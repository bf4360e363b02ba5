#include "firmware/stereo/point_cloud.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace adit::stereo {

using Eigen::Vector2d;
using Eigen::Vector3d;

PointCloud::PointCloud(const optics::Rig& rig, const LocatorOptions& options)
    : views_(MakeViews(rig)),
      options_(options),
      image_px2_{static_cast<double>(rig.left.width_px) * rig.left.height_px,
                 static_cast<double>(rig.right.width_px) * rig.right.height_px} {
  const Vector3d base = views_[1].CentreM().normalized();
  forward_ = (Vector3d::UnitZ() - base.z() * base).normalized();
  aside_ = base.cross(forward_);
}

std::optional<double> PointCloud::PlaneOf(const View& view, const Vector2d& px) const {
  constexpr double kForwardMin = 0.1;  // 84 degrees from straight ahead
  const Vector3d ray = view.Ray(px);
  const double forward = ray.dot(forward_);
  // Written so that NaN is nothing.
  if (!(forward > kForwardMin)) return std::nullopt;
  const double plane = ray.dot(aside_) / forward;
  return std::isfinite(plane) ? std::optional(plane) : std::nullopt;
}

void PointCloud::SortRight(const detect::BlobSet& right, const BlobFlags& claimed) {
  right_order_.clear();
  planes_per_px_ = 0;
  for (std::size_t i = 0; i < right.blobs.size(); ++i) {
    if (claimed[1][i]) continue;
    const Vector2d& px = right.blobs[i].ideal_px;
    const auto plane = PlaneOf(views_[1], px);
    if (!plane) continue;
    right_order_.push_back({*plane, static_cast<std::uint16_t>(i)});
    // Two pixels along u and along v say how steep it is here; nearly the same everywhere.
    for (const Vector2d& step : {Vector2d(1, 0), Vector2d(0, 1)}) {
      const auto beside = PlaneOf(views_[1], px + step);
      if (beside) planes_per_px_ = std::max(planes_per_px_, std::abs(*beside - *plane));
    }
  }
  std::sort(right_order_.begin(), right_order_.end(),
            [](const Place& a, const Place& b) { return a.key < b.key; });
}

void PointCloud::Build(const detect::BlobSet& left, const detect::BlobSet& right, const BlobFlags& claimed,
                       const Correspondence& correspondence) {
  points_.clear();
  crowded_ = false;
  blobs_per_px2_ = {static_cast<double>(left.blobs.size()) / image_px2_[0],
                    static_cast<double>(right.blobs.size()) / image_px2_[1]};
  SortRight(right, claimed);
  left_order_.clear();
  for (std::size_t i = 0; i < left.blobs.size(); ++i) {
    if (!claimed[0][i] && left.blobs[i].ideal_px.allFinite())
      left_order_.push_back({left.blobs[i].ideal_px.x(), static_cast<std::uint16_t>(i)});
  }
  std::sort(left_order_.begin(), left_order_.end(),
            [](const Place& a, const Place& b) { return a.key < b.key; });
  // The gradient is at most the root of two of its larger component, and the plane is nearly linear over a
  // few pixels.
  constexpr double kSteeper = 1.6;
  for (const Place& place : left_order_) {
    const detect::Blob& blob = left.blobs[place.blob];
    const auto plane = PlaneOf(views_[0], blob.ideal_px);
    const auto line = correspondence.LineOf(blob);
    if (!plane || !line) continue;
    const double reach = kSteeper * planes_per_px_ * line->widest_px;
    const auto* first = std::lower_bound(right_order_.begin(), right_order_.end(), *plane - reach,
                                         [](const Place& p, double key) { return p.key < key; });
    for (; first != right_order_.end() && first->key <= *plane + reach; ++first) {
      const detect::Blob& other = right.blobs[first->blob];
      if (correspondence.Near(*line, blob, other)) Add(blob, place.blob, other, first->blob);
    }
  }
}

std::size_t PointCloud::FirstFrom(double column_px) const {
  const auto* first =
      std::lower_bound(points_.begin(), points_.end(), column_px,
                       [](const CloudPoint& p, double column) { return p.px[0].x() < column; });
  return static_cast<std::size_t>(first - points_.begin());
}

void PointCloud::Add(const detect::Blob& left, std::uint16_t left_blob, const detect::Blob& right,
                     std::uint16_t right_blob) {
  const auto middle = Midpoint(views_, left.ideal_px, right.ideal_px);
  if (!middle) return;
  CloudPoint p;
  p.point_b_m = *middle;
  p.px = {left.ideal_px, right.ideal_px};
  p.blobs = {left_blob, right_blob};
  for (std::size_t side = 0; side < 2; ++side) {
    const View& view = views_[side];
    p.depth_m[side] = view.rotation.row(2).dot(*middle) + view.translation_m.z();
    constexpr double kNearestM = 0.5;
    if (!(p.depth_m[side] > kNearestM)) return;
  }
  const double floor_px2 = options_.centroid_floor_px * options_.centroid_floor_px;
  p.noise_px = std::sqrt(std::max(left.covariance_px2.trace(), right.covariance_px2.trace()) / 2 + floor_px2);
  // Both rays turn by the noise; they meet at a small angle.
  const Vector3d& a = *middle;
  const Vector3d b = a - views_[1].CentreM();
  const double sine = a.cross(b).norm() / (a.norm() * b.norm());
  p.range_sigma_m = std::sqrt(2.0) * p.noise_px * a.norm() / (views_[0].fu_px * sine);
  if (!(p.range_sigma_m <= kDepthSigmaMax * a.norm())) return;
  if (!points_.push_back(p)) crowded_ = true;
}

}  // namespace adit::stereo
