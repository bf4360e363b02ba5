#include "host/opencv_intrinsics.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace adit::host {
namespace {

struct OpenCvCorners {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> image;
};

OpenCvCorners ForOpenCv(std::span<const BoardView> views) {
  OpenCvCorners all;
  for (const BoardView& view : views) {
    std::vector<cv::Point3f> board;
    std::vector<cv::Point2f> image;
    for (const BoardCorner& corner : view.corners) {
      board.emplace_back(static_cast<float>(corner.board_m.x()), static_cast<float>(corner.board_m.y()),
                         0.0F);
      image.emplace_back(static_cast<float>(corner.image_px.x()), static_cast<float>(corner.image_px.y()));
    }
    all.board.push_back(std::move(board));
    all.image.push_back(std::move(image));
  }
  return all;
}

optics::CameraModel FromOpenCv(const cv::Matx33d& k, const cv::Mat& distortion, cv::Size size) {
  return {k(0, 0),
          k(1, 1),
          k(0, 2),
          k(1, 2),
          distortion.at<double>(0),
          distortion.at<double>(1),
          distortion.at<double>(2),
          distortion.at<double>(3),
          size.width,
          size.height};
}

}  // namespace

std::optional<IntrinsicsStart> StartIntrinsics(std::span<const BoardView> views, int width_px,
                                               int height_px) {
  const OpenCvCorners all = ForOpenCv(views);
  const cv::Size size(width_px, height_px);
  try {
    cv::Matx33d k = cv::initCameraMatrix2D(all.board, all.image, size);
    const double focal_px = k(0, 0);
    const double longest_px = 100.0 * width_px;  // a view of 0.6 degrees
    if (!(std::isfinite(focal_px) && std::isfinite(k(1, 1)) && focal_px > 0.1 * width_px &&
          focal_px < longest_px))
      k = {1.0 * width_px, 0, (width_px - 1) / 2.0, 0, 1.0 * width_px, (height_px - 1) / 2.0, 0, 0, 1};
    IntrinsicsStart start;
    start.camera = FromOpenCv(k, cv::Mat::zeros(1, 4, CV_64F), size);
    for (std::size_t i = 0; i < views.size(); ++i) {
      cv::Vec3d rotation, translation;
      if (!cv::solvePnP(all.board[i], all.image[i], k, cv::noArray(), rotation, translation))
        return std::nullopt;
      start.poses.push_back(
          {{rotation[0], rotation[1], rotation[2]}, {translation[0], translation[1], translation[2]}});
    }
    return start;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

std::optional<OpenCvIntrinsics> SolveByOpenCv(std::span<const BoardView> views, int width_px, int height_px) {
  const OpenCvCorners all = ForOpenCv(views);
  const cv::Size size(width_px, height_px);
  cv::Mat k, distortion, sigma, sigma_poses, errors;
  std::vector<cv::Mat> rotations, translations;
  try {
    // OpenCV stops after 30 steps by default, which leaves hundredths of a pixel in the focal length.
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 1000, 1e-12);
    OpenCvIntrinsics out;
    out.rms_px = cv::calibrateCamera(all.board, all.image, size, k, distortion, rotations, translations,
                                     sigma, sigma_poses, errors, cv::CALIB_FIX_K3, until);
    out.camera = FromOpenCv(k, distortion, size);
    for (int i = 0; i < kIntrinsics; ++i) out.sigma[i] = sigma.at<double>(i);
    return out;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
}

}  // namespace adit::host
