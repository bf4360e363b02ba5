// A calibration board's corners in an image, sharp or blurred, in visible or near-infrared light.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "host/board.h"

namespace adit::host {

/// One corner of the board in one image.
struct BoardCorner {
  int id = 0;                ///< of the board
  Eigen::Vector2d board_m;   ///< on the board
  Eigen::Vector2d image_px;  ///< raw pixel; (0,0) is the centre of the first
};

/// What one image shows of the board.
struct BoardView {
  std::string image;
  std::vector<BoardCorner> corners;  ///< ascending ids
  std::string fault;                 ///< why the image cannot be used; empty if it can
};

/// Fewer corners of a ChArUco board than this leave little beside the board's own pose (6 parameters).
constexpr std::size_t kBoardCornersMin = 8;

/// Finds the board in a grey image of 8 or 16 bit. Contrast is stretched first, evened out where that does
/// not help (near infrared makes some inks pale and lamps leave gradients), and blurred images are searched
/// at half size too. The corners are then refined in the full image as saddle points (OpenCV's cornerSubPix);
/// the window of each is 0.3 of the distance to its nearest neighbour, so that no other corner reaches into
/// it. `fault` says when there is no board, or too little of it.
BoardView FindBoard(const Board& board, const std::string& name, const cv::Mat& grey);

}  // namespace adit::host
