// Every point that a left blob and a right one could be.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>

#include "firmware/stereo/correspondence.h"

namespace adit::stereo {

/// Two blobs on one epipolar line, and where they would be one light.
struct CloudPoint {
  Eigen::Vector3d point_b_m = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector2d, 2> px;     ///< ideal, left and right
  std::array<double, 2> depth_m{};       ///< in the left camera and in the right one
  std::array<std::uint16_t, 2> blobs{};  ///< in the left image and in the right one
  double noise_px = 0;                   ///< of the worse centroid, floor included
  double range_sigma_m = 0;              ///< along the line of sight
};

/// Blobs of the left image and of the right one, by index.
using BlobFlags = std::array<std::bitset<detect::kMaxBlobs>, 2>;

/// The points of one pair, sorted by their column in the left image. About half a right blob lies on a line
/// among 200 lamps: the points are about as many as the blobs. One thread; no allocation.
class PointCloud {
 public:
  static constexpr std::size_t kMaxPoints = 2048;

  PointCloud(const optics::Rig& rig, const LocatorOptions& options);

  /// `correspondence` has the right image set. Blobs that are `claimed` or no numbers are passed over.
  void Build(const detect::BlobSet& left, const detect::BlobSet& right, const BlobFlags& claimed,
             const Correspondence& correspondence);

  const Views& GetViews() const { return views_; }
  std::size_t size() const { return points_.size(); }
  const CloudPoint& operator[](std::size_t i) const { return points_[i]; }
  /// Index of the first point at or right of a column of the left image.
  std::size_t FirstFrom(double column_px) const;
  /// More points than fit: nothing may be concluded from these.
  bool Crowded() const { return crowded_; }
  /// Right blobs of one pixel^2 of their image, and left ones of theirs.
  const std::array<double, 2>& BlobsPerPx2() const { return blobs_per_px2_; }

 private:
  struct Place {
    double key = 0;
    std::uint16_t blob = 0;
  };
  using Order = base::FixedVector<Place, detect::kMaxBlobs>;

  void SortRight(const detect::BlobSet& right, const BlobFlags& claimed);
  void Add(const detect::Blob& left, std::uint16_t left_blob, const detect::Blob& right,
           std::uint16_t right_blob);
  /// Tangent of the angle of the plane through both cameras and the pixel; nothing for rays along the base.
  std::optional<double> PlaneOf(const View& view, const Eigen::Vector2d& px) const;

  Views views_;
  LocatorOptions options_;
  Eigen::Vector3d forward_, aside_;  ///< across the baseline
  std::array<double, 2> image_px2_;
  Order left_order_, right_order_;  ///< by column; by plane
  double planes_per_px_ = 0;        ///< no pixel of the right image moves its plane by more
  base::FixedVector<CloudPoint, kMaxPoints> points_;
  std::array<double, 2> blobs_per_px2_{};
  bool crowded_ = false;
};

}  // namespace adit::stereo
