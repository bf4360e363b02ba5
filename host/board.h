// The flat calibration board: a chessboard, or a ChArUco board, whose white squares hold markers that name
// every corner, so that a part of the board is enough.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "firmware/base/result.h"

namespace adit::host {

/// A board's corners are those inside it, where four squares meet.
struct Board {
  int columns = 0, rows = 0;  ///< of corners: one less than squares
  double square_m = 0;        ///< side of a square

  struct Markers {
    std::string dictionary;  ///< as OpenCV names it: DICT_4X4_50
    double side_m = 0;       ///< shorter than the square's
  };
  std::optional<Markers> markers;  ///< empty: a plain chessboard

  int Corners() const { return columns * rows; }
  /// Place on the board of corner `id` (rows one after the other): x along a row, y down, m.
  Eigen::Vector2d CornerM(int id) const { return {id % columns * square_m, id / columns * square_m}; }
  /// "9x6 chessboard, squares of 40 mm"
  std::string Text() const;
};

/// "9x6" -> columns and rows of corners, each from 3 to 100.
base::Result<Board> ParseBoard(const std::string& corners, double square_m);

/// OpenCV's number of a marker dictionary's name; empty if there is none of that name.
std::optional<int> MarkerDictionary(const std::string& name);

/// The board with markers. Refuses an unknown dictionary, one with fewer markers than the board has white
/// squares, and markers that are not smaller than the squares.
base::Result<Board> WithMarkers(Board board, const std::string& dictionary, double side_m);

}  // namespace adit::host
