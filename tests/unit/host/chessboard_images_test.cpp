// OpenCV's own sample images (tests/data/chessboard) against its usual way: corners of findChessboardCorners
// refined in 11 x 11 px, and calibrateCamera.
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "host/board_image.h"
#include "host/intrinsic_calibration.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Board;
using adit::host::BoardView;
using adit::host::FindBoard;

std::vector<std::string> Images(const std::string& side) {
  std::vector<std::string> images;
  const auto all = adit::host::ListImages({"tests/data/chessboard"});
  for (const std::string& path : *all) {
    if (path.find(side) != std::string::npos) images.push_back(path);
  }
  return images;
}

/// A calibration on all images, and what OpenCV's own functions give.
struct Pair {
  adit::host::IntrinsicCalibration ours;
  cv::Matx33d camera_matrix;
  double rms_px = 0;
};

Pair CalibrateBoth(const std::string& side) {
  const Board board = *adit::host::ParseBoard("9x6", 0.025);
  std::vector<BoardView> views;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<cv::Point3f> points;
  for (int id = 0; id < board.Corners(); ++id) {
    points.emplace_back(static_cast<float>(board.CornerM(id).x()), static_cast<float>(board.CornerM(id).y()),
                        0.0F);
  }
  for (const std::string& path : Images(side)) {
    const cv::Mat image = *adit::host::ReadBoardImage(path);
    views.push_back(FindBoard(board, path, image));
    std::vector<cv::Point2f> found;
    CHECK(cv::findChessboardCorners(image, {9, 6}, found));
    cv::cornerSubPix(image, found, {5, 5}, {-1, -1}, {3, 100, 1e-4});
    corners.push_back(found);
  }
  auto calibration = adit::host::CalibrateIntrinsics(views, 640, 480);
  if (!calibration) FAIL(calibration.error().Line().c_str());
  Pair pair{*calibration, {}, 0};
  cv::Mat distortion;
  std::vector<cv::Mat> rotations, translations;
  const std::vector<std::vector<cv::Point3f>> boards(corners.size(), points);
  pair.rms_px = cv::calibrateCamera(boards, corners, {640, 480}, pair.camera_matrix, distortion, rotations,
                                    translations, cv::CALIB_FIX_K3);
  return pair;
}

void CheckAlike(const Pair& pair) {
  LONGS_EQUAL(13, pair.ours.ImagesUsed());
  DOUBLES_EQUAL(pair.camera_matrix(0, 0), pair.ours.camera.fu_px, 1);
  DOUBLES_EQUAL(pair.camera_matrix(1, 1), pair.ours.camera.fv_px, 1);
  DOUBLES_EQUAL(pair.camera_matrix(0, 2), pair.ours.camera.cu_px, 1);
  DOUBLES_EQUAL(pair.camera_matrix(1, 2), pair.ours.camera.cv_px, 1);
  DOUBLES_EQUAL(pair.rms_px, pair.ours.rms_px, 0.05);
  CHECK(pair.ours.rms_px < pair.rms_px);
  // On the same corners nothing but rounding is between the two solutions.
  CHECK(pair.ours.opencv.has_value());
  DOUBLES_EQUAL(pair.ours.opencv->camera.fu_px, pair.ours.camera.fu_px, 0.01);
  DOUBLES_EQUAL(pair.ours.opencv->rms_px, pair.ours.rms_px, 1e-4);
}

}  // namespace

TEST_GROUP(ChessboardImages){};

TEST(ChessboardImages, LeftCameraIsAsOpenCvFindsIt) { CheckAlike(CalibrateBoth("left")); }

TEST(ChessboardImages, RightCameraIsAsOpenCvFindsIt) { CheckAlike(CalibrateBoth("right")); }

TEST(ChessboardImages, BoardIsFoundInEveryImageWhenBlurred) {
  const Board board = *adit::host::ParseBoard("9x6", 0.025);
  int found = 0;
  const auto images = Images("left");
  for (const std::string& path : images) {
    cv::Mat image = *adit::host::ReadBoardImage(path);
    cv::GaussianBlur(image, image, {}, 4);  // squares of 18 to 45 px
    found += FindBoard(board, path, image).fault.empty() ? 1 : 0;
  }

  LONGS_EQUAL(images.size(), found);
}
