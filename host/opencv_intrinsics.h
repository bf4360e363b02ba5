// OpenCV's calibration of one camera: the start of ours, and the second opinion on it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/intrinsics_bundle.h"

namespace adit::host {

struct IntrinsicsStart {
  optics::CameraModel camera;
  std::vector<BoardPose> poses;  ///< one a view
};

/// Zhang's closed form for a principal point in the image's middle (OpenCV's initCameraMatrix2D), then each
/// board's pose. Boards that face the camera all alike leave the focal length open: it then starts at the
/// image's width. Declines when the poses cannot be found.
std::optional<IntrinsicsStart> StartIntrinsics(std::span<const BoardView> views, int width_px, int height_px);

struct OpenCvIntrinsics {
  optics::CameraModel camera;
  IntrinsicVector sigma = IntrinsicVector::Zero();  ///< as OpenCV states them, see SolveByOpenCv
  double rms_px = 0;                                ///< of corners, both coordinates together
};

/// cv::calibrateCamera with its own start on the same corners, for the same model (k3 fixed at 0). Declines
/// where OpenCV throws. The standard deviations that OpenCV 4.6 states take one residual a corner for one a
/// coordinate: for N corners and p parameters they are too large by sqrt((2 N - p) / (N - p)), above sqrt(2).
std::optional<OpenCvIntrinsics> SolveByOpenCv(std::span<const BoardView> views, int width_px, int height_px);

}  // namespace adit::host
