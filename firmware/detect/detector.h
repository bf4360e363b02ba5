// Frame -> BlobSet: threshold, connected components, gates, centroids with covariance, undistortion.
#pragma once

#include <memory>

#include "firmware/base/image.h"
#include "firmware/detect/blob_set.h"
#include "firmware/detect/window.h"
#include "firmware/optics/camera_model.h"

namespace adit::detect {

/// What counts as a possible LED. Pixels are of the full image.
struct DetectorOptions {
  double area_min_px = 4;     ///< above threshold; below it no centroid is worth its name
  double area_max_px = 1200;  ///< a 60 mm sphere at 5 m is 40 px wide
  double elongation_max =
      2.2;  ///< ratio of the second moments' axes: LEDs are round, smeared ones a little less
  double read_noise_dn = 1.5;    ///< of the camera at 8 bit, for the covariance
  double electrons_per_dn = 40;  ///< conversion gain at 8 bit, for the shot noise
};

/// The detection of one camera. One object per camera and thread; no allocation after construction.
class Detector {
 public:
  Detector(const optics::CameraModel& camera, const DetectorOptions& options);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Fills `out` from `frame`, all of it or `windows` of it: a blob that lies inside a window is the same
  /// either way. A frame that is not kOk, or not of the camera's size, gives an empty set whose stamp says
  /// why.
  void Detect(const base::CameraFrame& frame, const Windows& windows, BlobSet& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace adit::detect
