// A camera with known intrinsics before a board: corners projected by OpenCV, and images rendered by code of
// the tests' own.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "host/intrinsic_calibration.h"

namespace adit::tests {

inline optics::CameraModel BoardCamera() {
  return {820.0, 823.0, 331.5, 236.2, -0.21, 0.12, 0.0006, -0.0009, 640, 480};
}

inline host::Board SyntheticBoard() { return *host::ParseBoard("9x6", 0.04); }

/// How a board is held.
struct SyntheticPose {
  cv::Vec3d rotation_rad, translation_m;
  double bow_m = 0;  ///< by which its middle stands off the plane of its ends
};

/// Rotation about the image's x, then y, then the axis; the middle of the board stands at `middle_m`.
inline SyntheticPose PoseAt(const host::Board& board, const cv::Vec3d& turn_rad, const cv::Vec3d& middle_m) {
  cv::Matx33d about_x, about_y, about_z;
  cv::Rodrigues(cv::Vec3d(turn_rad[0], 0, 0), about_x);
  cv::Rodrigues(cv::Vec3d(0, turn_rad[1], 0), about_y);
  cv::Rodrigues(cv::Vec3d(0, 0, turn_rad[2]), about_z);
  const cv::Matx33d rotation = about_y * about_x * about_z;
  const cv::Vec3d half_m((board.columns - 1) * board.square_m / 2, (board.rows - 1) * board.square_m / 2, 0);
  SyntheticPose pose;
  cv::Rodrigues(rotation, pose.rotation_rad);
  pose.translation_m = middle_m - rotation * half_m;
  return pose;
}

/// Boards held before the camera by hand: tilted up to `tilt_rad` both ways, all over the image.
inline std::vector<SyntheticPose> HeldBoards(const host::Board& board, std::size_t count, double tilt_rad,
                                             std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<SyntheticPose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double z_m = 0.75 + 0.15 * unit(random);
    poses.push_back(PoseAt(board, {tilt_rad * unit(random), tilt_rad * unit(random), 0.4 * unit(random)},
                           {0.12 * z_m * unit(random), 0.1 * z_m * unit(random), z_m}));
  }
  return poses;
}

/// Corners with Gaussian noise.
inline host::BoardView Seen(const host::Board& board, const optics::CameraModel& c, const SyntheticPose& pose,
                            double noise_px, std::mt19937_64& random) {
  std::vector<cv::Point3d> points;
  for (int id = 0; id < board.Corners(); ++id) {
    const Eigen::Vector2d place_m = board.CornerM(id);
    const double along = 2 * place_m.x() / ((board.columns - 1) * board.square_m) - 1;
    points.emplace_back(place_m.x(), place_m.y(), pose.bow_m * (1 - along * along));
  }
  const cv::Matx33d k(c.fu_px, 0, c.cu_px, 0, c.fv_px, c.cv_px, 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, pose.rotation_rad, pose.translation_m, k, cv::Vec4d(c.k1, c.k2, c.p1, c.p2),
                    pixels);
  std::normal_distribution<double> noise(0, 1);
  host::BoardView view;
  for (int id = 0; id < board.Corners(); ++id) {
    const cv::Point2d& pixel = pixels[static_cast<std::size_t>(id)];
    const double du_px = noise_px * noise(random), dv_px = noise_px * noise(random);
    view.corners.push_back({id, board.CornerM(id), {pixel.x + du_px, pixel.y + dv_px}});
  }
  return view;
}

/// Views named "0", "1", ... of held boards.
inline std::vector<host::BoardView> SeenBoards(const host::Board& board, std::size_t count, double noise_px,
                                               std::mt19937_64& random) {
  std::vector<host::BoardView> views;
  for (const SyntheticPose& pose : HeldBoards(board, count, 0.7, random)) {
    views.push_back(Seen(board, BoardCamera(), pose, noise_px, random));
    views.back().image = std::to_string(views.size() - 1);
  }
  return views;
}

/// What a rendered image goes through.
struct Rendering {
  double dark = 40, bright = 210;  ///< levels of the squares; around the board it is bright
  double blur_px = 0.7;            ///< standard deviation of the lens's spot
  double noise = 2;                ///< levels
};

/// The image of a flat texture (8 bit grey, `texel_m` a texel, its texel corner (0,0) at `corner_m` on the
/// board) through a pinhole camera without distortion, 4 x 4 samples a pixel, as 32 bit levels.
inline cv::Mat RenderTexture(const cv::Mat& texture, double texel_m, const cv::Vec2d& corner_m,
                             const optics::CameraModel& c, const SyntheticPose& pose) {
  cv::Matx33d rotation;
  cv::Rodrigues(pose.rotation_rad, rotation);
  const cv::Vec3d normal(rotation(0, 2), rotation(1, 2), rotation(2, 2));
  constexpr int kSamples = 4;
  cv::Mat image(c.height_px, c.width_px, CV_32F);
  for (int v = 0; v < c.height_px; ++v) {
    for (int u = 0; u < c.width_px; ++u) {
      double sum = 0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double du = (s % kSamples + 0.5) / kSamples - 0.5, dv = (s / kSamples + 0.5) / kSamples - 0.5;
        const cv::Vec3d ray((u + du - c.cu_px) / c.fu_px, (v + dv - c.cv_px) / c.fv_px, 1);
        const cv::Vec3d point = ray * (normal.dot(pose.translation_m) / normal.dot(ray)) - pose.translation_m;
        const cv::Vec3d on_board = rotation.t() * point;
        const int column = static_cast<int>(std::floor((on_board[0] - corner_m[0]) / texel_m));
        const int row = static_cast<int>(std::floor((on_board[1] - corner_m[1]) / texel_m));
        const bool inside = column >= 0 && row >= 0 && column < texture.cols && row < texture.rows;
        sum += inside ? texture.at<uchar>(row, column) / 255.0 : 1.0;
      }
      image.at<float>(v, u) = static_cast<float>(sum / (kSamples * kSamples));
    }
  }
  return image;
}

/// Blurred, with noise, at the levels of `how`, in `type` (CV_8U, CV_16U).
inline cv::Mat Exposed(const cv::Mat& rendered, const Rendering& how, int type, std::mt19937_64& random) {
  cv::Mat image = rendered * (how.bright - how.dark) + how.dark;
  cv::GaussianBlur(image, image, {}, how.blur_px);
  std::normal_distribution<float> noise(0, static_cast<float>(how.noise));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image.at<float>(v, u) += noise(random);
  }
  cv::Mat out;
  image.convertTo(out, type);
  return out;
}

/// A chessboard's squares, one texel each, with one more row and column than corners.
inline cv::Mat ChessboardTexture(const host::Board& board) {
  cv::Mat texture(board.rows + 1, board.columns + 1, CV_8U);
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column)
      texture.at<uchar>(row, column) = (row + column) % 2 == 0 ? 0 : 255;
  }
  return texture;
}

}  // namespace adit::tests
