#include "host/board.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <opencv2/aruco.hpp>
#include <sstream>
#include <utility>

namespace adit::host {
namespace {

constexpr int kCornersMin = 3, kCornersMax = 100;  // OpenCV finds no board of two rows

constexpr std::array<std::pair<const char*, int>, 17> kDictionaries{{
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
}};

}  // namespace

std::string Board::Text() const {
  std::ostringstream text;
  text << columns << "x" << rows << (markers ? " ChArUco board, squares of " : " chessboard, squares of ")
       << square_m * 1e3 << " mm";
  if (markers) text << ", markers of " << markers->side_m * 1e3 << " mm from " << markers->dictionary;
  return text.str();
}

base::Result<Board> ParseBoard(const std::string& corners, double square_m) {
  Board board;
  board.square_m = square_m;
  int read = 0;
  const bool whole = std::sscanf(corners.c_str(), "%3dx%3d%n", &board.columns, &board.rows, &read) == 2 &&
                     static_cast<std::size_t>(read) == corners.size();
  const auto [least, most] = std::minmax(board.columns, board.rows);
  if (!whole || least < kCornersMin || most > kCornersMax) {
    return base::Error{base::ErrorCode::kUsage, "--board",
                       "is '" + corners +
                           "'; it must be COLUMNSxROWS of the corners inside the board, each from 3 to 100: "
                           "10 by 7 squares are 9x6"};
  }
  return board;
}

std::optional<int> MarkerDictionary(const std::string& name) {
  for (const auto& [known, number] : kDictionaries) {
    if (name == known) return number;
  }
  return std::nullopt;
}

base::Result<Board> WithMarkers(Board board, const std::string& dictionary, double side_m) {
  const auto number = MarkerDictionary(dictionary);
  if (!number) {
    std::string known;
    for (const auto& entry : kDictionaries) known += std::string(known.empty() ? "" : ", ") + entry.first;
    return base::Error{base::ErrorCode::kUsage, "--charuco",
                       "is '" + dictionary + "'; it must be one of " + known};
  }
  if (!(side_m > 0 && side_m < board.square_m)) {
    std::ostringstream text;
    text << "is " << side_m << "; it must be above 0 and below the square's " << board.square_m << " m";
    return base::Error{base::ErrorCode::kUsage, "--marker-m", text.str()};
  }
  const int white = (board.columns + 1) * (board.rows + 1) / 2;
  const int markers = cv::aruco::getPredefinedDictionary(*number)->bytesList.rows;
  if (white > markers) {
    return base::Error{base::ErrorCode::kUsage, "--charuco",
                       "is " + dictionary + ", which has " + std::to_string(markers) +
                           " markers; the board's white squares need " + std::to_string(white)};
  }
  board.markers = Board::Markers{dictionary, side_m};
  return board;
}

}  // namespace adit::host
