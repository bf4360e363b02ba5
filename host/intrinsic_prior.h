// What is known of a camera before a rig is calibrated with it.
#pragma once

#include <string>

#include "firmware/base/result.h"
#include "firmware/optics/camera_model.h"
#include "host/intrinsic_parameters.h"

namespace adit::host {

/// One standard deviation of what a camera file that does not state its own is believed to be wrong by; the
/// defaults are what a careful chessboard calibration leaves.
struct IntrinsicSigmas {
  double focal_pct = 0.05;     ///< of fu and fv together
  double centre_px = 1;        ///< of each coordinate of the principal point
  double distortion_px = 0.2;  ///< at the image's corner, by k1
};

/// Intrinsics = those of the camera file + root z, with z standard normal: fewer than 8 columns of `root`
/// that are not zero keep the others as they are.
struct IntrinsicPrior {
  IntrinsicMatrix root = IntrinsicMatrix::Zero();
  bool is_measured = false;  ///< from the file's own covariance

  bool IsExact() const { return root.isZero(0); }
  IntrinsicMatrix Covariance() const { return root * root.transpose(); }
  /// z of intrinsics, the shortest one.
  IntrinsicVector Steps(const IntrinsicVector& mean, const IntrinsicVector& now) const;
};

IntrinsicPrior PriorOf(const IntrinsicSigmas& sigmas, const optics::CameraModel& camera);
/// `covariance` as `adit intrinsics` states it: fu, fv, cu, cv, k1, k2, p1, p2.
IntrinsicPrior PriorOf(const IntrinsicMatrix& covariance);

/// From the camera file's own covariance if it has one, else from `sigmas`. Declines one that is not 8 x 8,
/// symmetric and without negative variances.
base::Result<IntrinsicPrior> LoadPrior(const std::string& path, const IntrinsicSigmas& sigmas,
                                       const optics::CameraModel& camera);

}  // namespace adit::host
