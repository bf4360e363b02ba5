// Which right blobs may be the LEDs that the left image shows.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/identify/sighting_set.h"
#include "firmware/stereo/locator_options.h"
#include "firmware/stereo/triangulate.h"

namespace adit::stereo {

/// A right blob on the epipolar line of a left one, and the point the two would be.
struct Candidate {
  std::uint16_t blob = 0;
  LocatedPoint located;  ///< midpoint; covariance with the centroid floor
};

inline constexpr std::size_t kMaxCandidates = 24;  ///< a line of lamps along an epipolar line

/// The candidates of one LED.
struct LedCandidates {
  base::FixedVector<Candidate, kMaxCandidates> candidates;
  bool on_line = false;  ///< a blob lies on the epipolar line, whether or not it makes a point
  bool crowded = false;  ///< more candidates than fit: nothing may be concluded
};

/// The epipolar line of a left blob in the right image.
struct EpipolarLine {
  Eigen::Vector3d line = Eigen::Vector3d::Zero();  ///< its product with a homogeneous pixel is the distance
  double length = 0;                               ///< what `line` was divided by
  double widest_px = 0;                            ///< no right blob farther from it passes
};

/// The epipolar geometry of a rig, and the right blobs of one pair. One thread; no allocation.
class Correspondence {
 public:
  Correspondence(const optics::Rig& rig, const LocatorOptions& options);

  /// Sets the right image to search. `right` must outlive the searches.
  void SetRight(const detect::BlobSet& right);

  /// Every right blob within the gate around the epipolar line of `left` that makes a point in front of both
  /// cameras.
  void Find(const detect::Blob& left, LedCandidates& out) const;

  /// Declines where there is no line: the blob is no number.
  std::optional<EpipolarLine> LineOf(const detect::Blob& left) const;
  /// Whether `right` is near enough to the line: `epipolar_px` and `sigmas` of both centroids' noise.
  bool Near(const EpipolarLine& line, const detect::Blob& left, const detect::Blob& right) const;

 private:
  Views views_;
  Eigen::Matrix3d fundamental_;
  LocatorOptions options_;
  const detect::BlobSet* right_ = nullptr;
  std::size_t size_ = 0;
  std::array<double, detect::kMaxBlobs> x_px_{}, y_px_{};
  double variance_max_px2_ = 0;
};

/// The centroid of a blob as the geometry uses it.
Observation ObservationOf(const detect::Blob& blob);

}  // namespace adit::stereo
