#include "host/board_finder.h"

#include <opencv2/aruco/charuco.hpp>

#include "tests/support/synthetic_board.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Board;
using adit::host::BoardView;
using adit::host::FindBoard;
using adit::tests::Exposed;
using adit::tests::PoseAt;
using adit::tests::Rendering;
using adit::tests::SyntheticPose;

adit::optics::CameraModel Pinhole() { return {820, 820, 319.5, 239.5, 0, 0, 0, 0, 640, 480}; }

SyntheticPose Tilted(const Board& board) { return PoseAt(board, {0.3, -0.4, 0.2}, {0.01, -0.02, 0.8}); }

cv::Mat RenderChessboard(const Board& board, const SyntheticPose& pose) {
  return adit::tests::RenderTexture(adit::tests::ChessboardTexture(board), board.square_m,
                                    {-board.square_m, -board.square_m}, Pinhole(), pose);
}

/// OpenCV's own drawing of the board, seen at the pose.
cv::Mat RenderCharuco(const Board& board, const SyntheticPose& pose) {
  constexpr int kTexels = 48;  // a square
  const auto dictionary =
      cv::aruco::getPredefinedDictionary(*adit::host::MarkerDictionary(board.markers->dictionary));
  const auto charuco =
      cv::aruco::CharucoBoard::create(board.columns + 1, board.rows + 1, static_cast<float>(board.square_m),
                                      static_cast<float>(board.markers->side_m), dictionary);
  cv::Mat texture;
  charuco->draw({kTexels * (board.columns + 1), kTexels * (board.rows + 1)}, texture);
  return adit::tests::RenderTexture(texture, board.square_m / kTexels, {-board.square_m, -board.square_m},
                                    Pinhole(), pose);
}

/// Root mean square of the corners' distances from where they are; a chessboard may be found from its other
/// end.
double RmsPx(const Board& board, const BoardView& view, const SyntheticPose& pose) {
  std::mt19937_64 unused;
  const BoardView truth = adit::tests::Seen(board, Pinhole(), pose, 0, unused);
  double forward_px2 = 0, backward_px2 = 0;
  for (const auto& corner : view.corners) {
    const auto id = static_cast<std::size_t>(corner.id);
    forward_px2 += (corner.image_px - truth.corners[id].image_px).squaredNorm();
    backward_px2 += (corner.image_px - truth.corners[truth.corners.size() - 1 - id].image_px).squaredNorm();
  }
  const double least_px2 = board.markers ? forward_px2 : std::min(forward_px2, backward_px2);
  return std::sqrt(least_px2 / static_cast<double>(view.corners.size()));
}

}  // namespace

TEST_GROUP(BoardFinder) {
  Board board_ = adit::tests::SyntheticBoard();
  Board charuco_ = *adit::host::WithMarkers(board_, "DICT_4X4_50", 0.03);
  std::mt19937_64 random_{5};
};

TEST(BoardFinder, FindsCornersToHundredthsOfAPixel) {
  const auto pose = Tilted(board_);
  const auto view = FindBoard(board_, "a.png", Exposed(RenderChessboard(board_, pose), {}, CV_8U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  LONGS_EQUAL(54, view.corners.size());
  DOUBLES_EQUAL(0, RmsPx(board_, view, pose), 0.05);
}

TEST(BoardFinder, FindsBlurredBoards) {
  const auto pose = Tilted(board_);  // squares of 35 to 45 px
  const cv::Mat sharp = RenderChessboard(board_, pose);
  for (const auto& [blur_px, rms_max_px] : {std::pair(3.0, 0.1), std::pair(6.0, 0.4), std::pair(10.0, 2.5)}) {
    Rendering how;
    how.blur_px = blur_px;
    const auto view = FindBoard(board_, "a.png", Exposed(sharp, how, CV_8U, random_));

    STRCMP_EQUAL("", view.fault.c_str());
    LONGS_EQUAL(54, view.corners.size());
    DOUBLES_EQUAL(0, RmsPx(board_, view, pose), rms_max_px);
  }
}

TEST(BoardFinder, FindsPaleInkUnderALampAtTheSide) {
  const auto pose = Tilted(board_);
  cv::Mat lit = RenderChessboard(board_, pose) * 14 + 20;  // near infrared: 14 levels between ink and paper
  for (int u = 0; u < lit.cols; ++u) lit.col(u) *= 0.4 + 1.2 * u / lit.cols;
  Rendering how;
  how.dark = 0, how.bright = 1, how.noise = 1;
  const auto view = FindBoard(board_, "a.png", Exposed(lit, how, CV_8U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  LONGS_EQUAL(54, view.corners.size());
  DOUBLES_EQUAL(0, RmsPx(board_, view, pose), 0.3);
}

TEST(BoardFinder, ReadsSixteenBitImages) {
  const auto pose = Tilted(board_);
  Rendering how;
  how.dark = 300, how.bright = 2400, how.noise = 10;
  const auto view = FindBoard(board_, "a.png", Exposed(RenderChessboard(board_, pose), how, CV_16U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  DOUBLES_EQUAL(0, RmsPx(board_, view, pose), 0.05);
}

TEST(BoardFinder, FindsEveryCornerOfACharucoBoard) {
  const auto pose = Tilted(charuco_);
  const auto view = FindBoard(charuco_, "a.png", Exposed(RenderCharuco(charuco_, pose), {}, CV_8U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  LONGS_EQUAL(54, view.corners.size());
  DOUBLES_EQUAL(0, RmsPx(charuco_, view, pose), 0.08);
}

TEST(BoardFinder, NamesTheCornersOfACharucoBoardThatIsHalfInTheImage) {
  const auto pose = PoseAt(charuco_, {0.2, 0.3, 0.1}, {0.3, 0.15, 0.8});
  const auto view = FindBoard(charuco_, "a.png", Exposed(RenderCharuco(charuco_, pose), {}, CV_8U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  CHECK(view.corners.size() >= 10);
  CHECK(view.corners.size() < 54);
  DOUBLES_EQUAL(0, RmsPx(charuco_, view, pose), 0.1);
}

TEST(BoardFinder, FindsEnoughOfCharucoBoardsAtTheBorderForACalibration) {
  std::vector<BoardView> views;
  for (int i = 0; i < 8; ++i) {
    const double side = i % 2 == 0 ? 1 : -1, height = i % 4 < 2 ? 1 : -1;
    const auto pose =
        PoseAt(charuco_, {0.45 * side, 0.5 * height, 0.3 * i}, {0.2 * side, 0.13 * height, 0.7});
    views.push_back(FindBoard(charuco_, std::to_string(i) + ".png",
                              Exposed(RenderCharuco(charuco_, pose), {}, CV_8U, random_)));
  }

  const auto calibration = adit::host::CalibrateIntrinsics(views, 640, 480);

  if (!calibration) FAIL(calibration.error().Line().c_str());
  LONGS_EQUAL(8, calibration->ImagesUsed());
  CHECK(calibration->corners < 8 * 54);
  CHECK(calibration->Coverage().MissedCorners().empty());
  const adit::host::IntrinsicVector error =
      adit::host::Intrinsics(calibration->camera) - adit::host::Intrinsics(Pinhole());
  CHECK(error.cwiseQuotient(calibration->Sigma()).cwiseAbs().maxCoeff() < 4);
  DOUBLES_EQUAL(820, calibration->camera.fu_px, 1);
}

TEST(BoardFinder, FindsABlurredCharucoBoard) {
  const auto pose = Tilted(charuco_);
  Rendering how;
  how.blur_px = 2;  // modules of 5 px
  const auto view = FindBoard(charuco_, "a.png", Exposed(RenderCharuco(charuco_, pose), how, CV_8U, random_));

  STRCMP_EQUAL("", view.fault.c_str());
  CHECK(view.corners.size() >= 40);
  DOUBLES_EQUAL(0, RmsPx(charuco_, view, pose), 0.5);
}

TEST(BoardFinder, SaysThatThereIsNoBoard) {
  const cv::Mat empty = Exposed(cv::Mat::ones(480, 640, CV_32F), {}, CV_8U, random_);

  STRCMP_EQUAL("no board found", FindBoard(board_, "a.png", empty).fault.c_str());
  STRCMP_EQUAL("no board found", FindBoard(charuco_, "a.png", empty).fault.c_str());
}

TEST(BoardFinder, FindsNothingInAConstantImage) {
  STRCMP_EQUAL("no board found", FindBoard(board_, "a.png", cv::Mat::zeros(480, 640, CV_8U)).fault.c_str());
}
