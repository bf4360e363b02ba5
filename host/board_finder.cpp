#include "host/board_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "host/normal_matrix.h"

namespace adit::host {
namespace {

/// Corners by their ids, in one image.
struct FoundCorners {
  std::vector<int> ids;
  std::vector<cv::Point2f> places_px;
};

/// 8 bit from the image's darkest to its brightest thousandth: single hot pixels and glints do not count.
cv::Mat Stretched(const cv::Mat& grey) {
  constexpr double kTail = 0.001;
  std::vector<double> levels;
  levels.reserve(grey.total());
  for (int row = 0; row < grey.rows; ++row) {
    for (int column = 0; column < grey.cols; ++column)
      levels.push_back(grey.depth() == CV_8U ? grey.at<uchar>(row, column) : grey.at<ushort>(row, column));
  }
  const auto at = [&levels](double share) {
    const auto place =
        levels.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(levels.size() - 1));
    std::nth_element(levels.begin(), place, levels.end());
    return *place;
  };
  const double dark = at(kTail), bright = at(1 - kTail);
  cv::Mat out;
  const double gain = 255 / std::max(1.0, bright - dark);
  grey.convertTo(out, CV_8U, gain, -dark * gain);
  return out;
}

FoundCorners FindCharuco(const Board& board, const cv::Mat& image) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(*MarkerDictionary(board.markers->dictionary));
  const auto charuco =
      cv::aruco::CharucoBoard::create(board.columns + 1, board.rows + 1, static_cast<float>(board.square_m),
                                      static_cast<float>(board.markers->side_m), dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  // Blur spreads a module into its neighbours: only its inner third is read, and a border may be half grey.
  const auto how = cv::aruco::DetectorParameters::create();
  how->adaptiveThreshWinSizeMin = 5;
  how->adaptiveThreshWinSizeMax = 45;
  how->perspectiveRemoveIgnoredMarginPerCell = 0.33;
  how->maxErroneousBitsInBorderRate = 0.5;
  cv::aruco::detectMarkers(image, dictionary, markers, marker_ids, how);
  FoundCorners found;
  if (!markers.empty())
    cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, charuco, found.places_px, found.ids);
  return found;
}

FoundCorners FindChessboard(const Board& board, const cv::Mat& image) {
  FoundCorners found;
  const cv::Size size(board.columns, board.rows);
  // The first finds blurred boards too, some only normalised and some only as they are. The second finds what
  // that misses; without its fast check it takes minutes over an image of noise (a closed lens, stretched).
  const bool is_found = cv::findChessboardCornersSB(image, size, found.places_px, cv::CALIB_CB_EXHAUSTIVE) ||
                        cv::findChessboardCornersSB(image, size, found.places_px,
                                                    cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_NORMALIZE_IMAGE) ||
                        cv::findChessboardCorners(image, size, found.places_px,
                                                  cv::CALIB_CB_ADAPTIVE_THRESH |
                                                      cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK);
  if (!is_found) return {};
  for (int id = 0; id < board.Corners(); ++id) found.ids.push_back(id);
  return found;
}

/// The fullest find: all of the board ends the search at once.
FoundCorners Search(const Board& board, const cv::Mat& stretched) {
  cv::Mat even, half, smooth, sharp;
  cv::createCLAHE(4, {8, 8})->apply(stretched, even);
  cv::resize(stretched, half, {}, 0.5, 0.5, cv::INTER_AREA);
  // Brings back modules that blur has filled (of 2 px standard deviation in modules of 5 px); the noise that
  // it raises is smoothed over a pixel.
  cv::GaussianBlur(stretched, smooth, {}, 4);
  cv::addWeighted(stretched, 9, smooth, -8, 0, sharp);
  cv::GaussianBlur(sharp, sharp, {}, 1);
  FoundCorners best;
  for (const cv::Mat* image : std::array<const cv::Mat*, 4>{&stretched, &even, &half, &sharp}) {
    if (image == &sharp && !board.markers) break;  // for the markers alone: a chessboard is found without
    FoundCorners found = board.markers ? FindCharuco(board, *image) : FindChessboard(board, *image);
    if (image == &half) {
      for (cv::Point2f& place_px : found.places_px) place_px = 2 * place_px + cv::Point2f(0.5F, 0.5F);
    }
    if (found.ids.size() > best.ids.size()) best = std::move(found);
    if (static_cast<int>(best.ids.size()) == board.Corners()) break;
  }
  return best;
}

/// Distance from corner `i` to its nearest neighbour along a row or column of the board; infinite without
/// one.
double SpacingPx(const Board& board, const FoundCorners& found, std::size_t i) {
  double least_px = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < found.ids.size(); ++k) {
    const int columns = found.ids[k] % board.columns - found.ids[i] % board.columns;
    const int rows = found.ids[k] / board.columns - found.ids[i] / board.columns;
    if (std::abs(columns) + std::abs(rows) == 1)
      least_px = std::min(least_px, cv::norm(found.places_px[k] - found.places_px[i]));
  }
  return least_px;
}

void Refine(const Board& board, const cv::Mat& grey, FoundCorners& found) {
  std::vector<double> spacings_px, finite_px;
  for (std::size_t i = 0; i < found.ids.size(); ++i) {
    spacings_px.push_back(SpacingPx(board, found, i));
    if (std::isfinite(spacings_px.back())) finite_px.push_back(spacings_px.back());
  }
  if (finite_px.empty()) return;  // all alone: as the markers place them
  const auto middle = finite_px.begin() + static_cast<std::ptrdiff_t>(finite_px.size() / 2);
  std::nth_element(finite_px.begin(), middle, finite_px.end());
  // A little smoothing costs no sharpness on this scale and takes noise: the residuals of real images are
  // least here, 3 % below those of none, and grow beyond 0.06.
  constexpr double kSmoothing = 0.03;
  cv::Mat exact;
  grey.convertTo(exact, CV_32F);
  cv::GaussianBlur(exact, exact, {}, kSmoothing * *middle);
  // A marker's edges stand off its square's by the margin; a window that reached them would see more than one
  // saddle.
  const double margin = board.markers ? (1 - board.markers->side_m / board.square_m) / 2 : 1;
  const double share = std::min(0.3, margin);
  constexpr int kWindowMin = 2;  // half of 5 x 5 px
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4);
  for (std::size_t i = 0; i < found.ids.size(); ++i) {
    if (!std::isfinite(spacings_px[i])) continue;
    const int window = std::max(kWindowMin, static_cast<int>(share * spacings_px[i]));
    std::vector<cv::Point2f> one{found.places_px[i]};
    cv::cornerSubPix(exact, one, {window, window}, {-1, -1}, until);
    found.places_px[i] = one[0];
  }
}

/// Whether the corners span a plane: those of one row hold no pose.
bool SpanPlane(const std::vector<BoardCorner>& corners, double square_m) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const BoardCorner& corner : corners) mean += corner.board_m / static_cast<double>(corners.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const BoardCorner& corner : corners)
    spread +=
        (corner.board_m - mean) * (corner.board_m - mean).transpose() / static_cast<double>(corners.size());
  constexpr double kLeast = 0.3;  // standard deviation in squares; half of the corners one row apart have 0.5
  return SpectrumOf(spread).values[0] > kLeast * kLeast * square_m * square_m;
}

}  // namespace

BoardView FindBoard(const Board& board, const std::string& name, const cv::Mat& grey) {
  BoardView view;
  view.image = name;
  FoundCorners found = Search(board, Stretched(grey));
  if (found.ids.empty()) {
    view.fault = "no board found";
    return view;
  }
  Refine(board, grey, found);
  for (std::size_t i = 0; i < found.ids.size(); ++i) {
    view.corners.push_back(
        {found.ids[i], board.CornerM(found.ids[i]), {found.places_px[i].x, found.places_px[i].y}});
  }
  std::sort(view.corners.begin(), view.corners.end(),
            [](const BoardCorner& a, const BoardCorner& b) { return a.id < b.id; });
  if (view.corners.size() < kBoardCornersMin) {
    view.fault = std::to_string(view.corners.size()) + " corners found, at least " +
                 std::to_string(kBoardCornersMin) + " are needed";
  } else if (!SpanPlane(view.corners, board.square_m)) {
    view.fault = "the corners found stand in one line";
  }
  return view;
}

}  // namespace adit::host
