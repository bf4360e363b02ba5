// A camera's intrinsics from images of a flat board: which images and corners count, and what the result is
// worth.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/coverage.h"
#include "host/opencv_intrinsics.h"

namespace adit::host {

/// Fewer images cannot tell which of them is wrong.
constexpr std::size_t kBoardImagesMin = 5;

struct ImageReport {
  std::string image;
  std::size_t corners = 0;  ///< used, or found where the image is left out
  double rms_px = 0;        ///< of the corners used, both coordinates together
  std::string left_out;     ///< why; empty if the image counts
};

struct IntrinsicCalibration {
  optics::CameraModel camera;
  IntrinsicMatrix covariance =
      IntrinsicMatrix::Zero();  ///< in the order of kIntrinsicNames, scaled by sigma0
  double rms_px = 0;            ///< root mean square of the corners' distances from the model
  double sigma0_px = 0;         ///< standard deviation of a corner's coordinate, from the residuals
  double dispersion = 1;        ///< between images, beyond what sigma0 explains: ImageDispersion
  std::size_t corners = 0, corners_left_out = 0;
  std::vector<ImageReport> images;  ///< all, as given
  std::vector<CoverageMark> marks;  ///< the corners used
  std::optional<OpenCvIntrinsics> opencv;
  std::vector<std::string> warnings;  ///< what the result suffers from, for people

  IntrinsicVector Sigma() const { return covariance.diagonal().cwiseSqrt(); }
  std::size_t ImagesUsed() const;
  CoverageMap Coverage() const;
};

/// Adjusts camera and poses (AdjustIntrinsics, from OpenCV's start) robustly; leaves out images that repeat
/// another one's pose (within 1 px) or whose corners miss three times as far as those of the rest, then
/// corners beyond 5 sigma; ends with least squares over what remains. What
/// all images share does not show in the covariance: a print scaled by 1e-3 in one direction changes fu / fv
/// by that. Refuses (kUsage) a board found in no image; (kFailed) fewer than kBoardImagesMin images, and
/// images that leave a parameter open: one standard deviation of it would move the image's corner by more
/// than 1 % of half the diagonal.
base::Result<IntrinsicCalibration> CalibrateIntrinsics(std::vector<BoardView> views, int width_px,
                                                       int height_px);

}  // namespace adit::host
