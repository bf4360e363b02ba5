#include "firmware/stereo/correspondence.h"

#include <algorithm>
#include <cmath>

namespace adit::stereo {

using Eigen::Vector3d;

Observation ObservationOf(const detect::Blob& blob) { return {blob.ideal_px, blob.covariance_px2}; }

Correspondence::Correspondence(const optics::Rig& rig, const LocatorOptions& options)
    : views_(MakeViews(rig)), fundamental_(rig.Fundamental()), options_(options) {}

void Correspondence::SetRight(const detect::BlobSet& right) {
  right_ = &right;
  size_ = right.blobs.size();
  variance_max_px2_ = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    x_px_[i] = right.blobs[i].ideal_px.x(), y_px_[i] = right.blobs[i].ideal_px.y();
    // std::max keeps its first argument when the second is NaN.
    variance_max_px2_ = std::max(variance_max_px2_, right.blobs[i].covariance_px2.trace());
  }
}

std::optional<EpipolarLine> Correspondence::LineOf(const detect::Blob& left) const {
  EpipolarLine out;
  out.line = fundamental_ * left.ideal_px.homogeneous();
  out.length = out.line.head<2>().norm();
  if (!(out.length > 0)) return std::nullopt;
  out.line /= out.length;
  // How the line's distance from a place moves with the left centroid: at the scale of the pair, both images
  // weigh alike.
  const double floor_px2 = 2 * options_.centroid_floor_px * options_.centroid_floor_px;
  out.widest_px = options_.epipolar_px + options_.sigmas * std::sqrt(2 * left.covariance_px2.trace() +
                                                                     variance_max_px2_ + floor_px2);
  return out;
}

bool Correspondence::Near(const EpipolarLine& line, const detect::Blob& left,
                          const detect::Blob& right) const {
  const Vector3d place = right.ideal_px.homogeneous();
  const Vector3d by_left = fundamental_.transpose() * place / line.length;
  const double variance = by_left.head<2>().dot(left.covariance_px2 * by_left.head<2>()) +
                          line.line.head<2>().dot(right.covariance_px2 * line.line.head<2>()) +
                          2 * options_.centroid_floor_px * options_.centroid_floor_px;
  // Written so that NaN is not near.
  return std::abs(line.line.dot(place)) <= options_.epipolar_px + options_.sigmas * std::sqrt(variance);
}

void Correspondence::Find(const detect::Blob& left, LedCandidates& out) const {
  out.candidates.clear();
  out.on_line = out.crowded = false;
  const auto line = LineOf(left);
  if (!line) return;
  for (std::size_t i = 0; i < size_; ++i) {
    const double distance_px = line->line.x() * x_px_[i] + line->line.y() * y_px_[i] + line->line.z();
    if (!(std::abs(distance_px) <= line->widest_px)) continue;
    const detect::Blob& right = right_->blobs[i];
    if (!Near(*line, left, right)) continue;
    out.on_line = true;
    const auto located =
        TriangulateMidpoint(views_, {ObservationOf(left), ObservationOf(right)}, options_.centroid_floor_px);
    if (!located) continue;
    if (!out.candidates.push_back({static_cast<std::uint16_t>(i), *located})) out.crowded = true;
  }
}

}  // namespace adit::stereo
