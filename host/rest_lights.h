// Lights that stand still: single LEDs that fill the corners which a waved bar cannot reach.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "firmware/detect/blob_set.h"
#include "firmware/optics/rig.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// Finds the blobs of one camera that stay in their place over a recording.
class RestFinder {
 public:
  /// Counts the blobs of one frame, each with the light within half a pixel of it, if there is one.
  void Add(const detect::BlobSet& blobs);

  /// Lights seen in half of the frames or more, 20 at least, that scatter by less than 0.1 px rms: the means
  /// of their centroids. The covariance is that of the mean, by the scatter or by what the centroids promise,
  /// whichever is more, and 0.01 px (1 sigma), which no mean lessens: a light at rest keeps its place among
  /// the pixels, and with it the centroid's bias.
  std::vector<LedView> Lights(const optics::CameraModel& camera) const;

 private:
  struct Light {
    double count = 0;
    Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
    double squares_px2 = 0;  // of the distances from the mean
    Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  };
  using Cell = std::pair<int, int>;

  Light& At(const Eigen::Vector2d& raw_px);

  double frames_ = 0;
  std::multimap<Cell, Light> lights_;  // by the pixel in which each was seen first
};

/// What both cameras saw at rest in one recording.
struct RestLights {
  std::vector<LedView> left, right;
};

/// The lights that both cameras saw: within `gate_px` of each other's epipolar line by `rig`, in front of
/// both cameras, and neither with a second partner.
std::vector<StereoPoint> MatchLights(const RestLights& lights, const optics::Rig& rig, double gate_px);

}  // namespace adit::host
