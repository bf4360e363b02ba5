#include "host/intrinsic_calibration.h"

#include "tests/support/nees.h"
#include "tests/support/synthetic_board.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::BoardView;
using adit::host::CalibrateIntrinsics;
using adit::host::IntrinsicCalibration;
using adit::host::Intrinsics;
using adit::host::IntrinsicVector;
using adit::tests::BoardCamera;
using adit::tests::HeldBoards;
using adit::tests::PoseAt;
using adit::tests::Seen;
using adit::tests::SeenBoards;

IntrinsicCalibration MustCalibrate(const std::vector<BoardView>& views) {
  auto calibration = CalibrateIntrinsics(views, 640, 480);
  if (!calibration) FAIL(calibration.error().Line().c_str());
  return *calibration;
}

IntrinsicVector Error(const IntrinsicCalibration& calibration) {
  return Intrinsics(calibration.camera) - Intrinsics(BoardCamera());
}

bool Warns(const IntrinsicCalibration& calibration, const std::string& part) {
  return std::any_of(calibration.warnings.begin(), calibration.warnings.end(),
                     [&part](const std::string& warning) { return warning.find(part) != std::string::npos; });
}

}  // namespace

TEST_GROUP(IntrinsicCalibration) {
  adit::host::Board board_ = adit::tests::SyntheticBoard();
  std::mt19937_64 random_{20};
};

TEST(IntrinsicCalibration, IsExactOnExactCorners) {
  const auto calibration = MustCalibrate(SeenBoards(board_, 8, 0, random_));

  const IntrinsicVector error = Error(calibration).cwiseAbs();
  CHECK(error.head<4>().maxCoeff() < 1e-5);
  CHECK(error.tail<4>().maxCoeff() < 1e-7);
  LONGS_EQUAL(8, calibration.ImagesUsed());
  LONGS_EQUAL(8 * 54, calibration.corners);
  LONGS_EQUAL(0, calibration.corners_left_out);
}

TEST(IntrinsicCalibration, StatesTheUncertaintyThatItHas) {
  constexpr int kRuns = 30;
  double squares = 0, sigma0_px = 0;
  int dispersed = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto calibration = MustCalibrate(SeenBoards(board_, 12, 0.2, random_));
    squares += adit::support::Nees(Error(calibration), calibration.covariance);
    sigma0_px += calibration.sigma0_px / kRuns;
    dispersed += calibration.dispersion > 1 ? 1 : 0;
  }

  // chi2 of 30 x 8 degrees of freedom: 99.9 % lie between 173 and 317.
  CHECK(squares > 173);
  CHECK(squares < 317);
  DOUBLES_EQUAL(0.2, sigma0_px, 0.002);
  CHECK(dispersed <= 2);
}

TEST(IntrinsicCalibration, AgreesWithOpenCvInValuesAndInSigma) {
  const auto calibration = MustCalibrate(SeenBoards(board_, 10, 0.2, random_));

  CHECK(calibration.opencv.has_value());
  const IntrinsicVector sigma = calibration.Sigma() / calibration.dispersion;
  const IntrinsicVector apart = Intrinsics(calibration.camera) - Intrinsics(calibration.opencv->camera);
  CHECK(apart.cwiseQuotient(sigma).cwiseAbs().maxCoeff() < 0.01);
  DOUBLES_EQUAL(calibration.opencv->rms_px, calibration.rms_px, 1e-5);
  // OpenCV counts corners where coordinates belong.
  const double corners = 10 * 54, parameters = 8 + 6 * 10;
  const double too_large = std::sqrt((2 * corners - parameters) / (corners - parameters));
  for (int i = 0; i < adit::host::kIntrinsics; ++i)
    DOUBLES_EQUAL(too_large, calibration.opencv->sigma[i] / sigma[i], 0.01);
}

TEST(IntrinsicCalibration, NamesTheImageOfAnotherZoom) {
  auto views = SeenBoards(board_, 10, 0.1, random_);
  auto zoomed = BoardCamera();
  zoomed.fu_px *= 1.3, zoomed.fv_px *= 1.3, zoomed.k1 = 0.3;
  views[4] = Seen(board_, zoomed, HeldBoards(board_, 1, 0.7, random_)[0], 0.1, random_);
  views[4].image = "zoomed.png";

  const auto calibration = MustCalibrate(views);

  STRCMP_CONTAINS("its corners miss by", calibration.images[4].left_out.c_str());
  LONGS_EQUAL(9, calibration.ImagesUsed());
  CHECK(Error(calibration).cwiseQuotient(calibration.Sigma()).cwiseAbs().maxCoeff() < 4);
}

TEST(IntrinsicCalibration, LeavesOutSingleCornersAndKeepsTheirImage) {
  auto views = SeenBoards(board_, 10, 0.1, random_);
  views[2].corners[17].image_px.x() += 6;
  views[7].corners[40].image_px.y() -= 3;

  const auto calibration = MustCalibrate(views);

  LONGS_EQUAL(10, calibration.ImagesUsed());
  LONGS_EQUAL(2, calibration.corners_left_out);
  LONGS_EQUAL(53, calibration.images[2].corners);
  CHECK(Error(calibration).cwiseQuotient(calibration.Sigma()).cwiseAbs().maxCoeff() < 4);
}

TEST(IntrinsicCalibration, CountsABoardThatDidNotMoveOnce) {
  auto views = SeenBoards(board_, 8, 0.1, random_);
  std::mt19937_64 again(99);
  views.push_back(views[3]);
  views.back().image = "again.png";
  for (auto& corner : views.back().corners) corner.image_px.x() += again() % 2 == 0 ? 0.2 : -0.2;

  const auto calibration = MustCalibrate(views);

  STRCMP_EQUAL("the board stands where it stands in 3", calibration.images[8].left_out.c_str());
}

TEST(IntrinsicCalibration, EnlargesSigmaWhenTheBoardFlexesFromImageToImage) {
  double squares = 0;
  constexpr int kRuns = 8;
  std::normal_distribution<double> bow_m(0, 0.001);
  for (int run = 0; run < kRuns; ++run) {
    std::vector<BoardView> views;
    for (auto pose : HeldBoards(board_, 14, 0.7, random_)) {
      pose.bow_m = bow_m(random_);
      views.push_back(Seen(board_, BoardCamera(), pose, 0.05, random_));
    }
    const auto calibration = MustCalibrate(views);
    CHECK(calibration.dispersion > 1.5);
    CHECK(Warns(calibration, "is the board flat?"));
    squares += adit::support::Nees(Error(calibration), calibration.covariance);
  }

  // chi2 of 8 x 8 degrees of freedom has 99.9 % below 106; the scale itself is estimated from 14 images.
  CHECK(squares < 2 * 106);
}

TEST(IntrinsicCalibration, RefusesBoardsThatAllFaceTheCamera) {
  std::vector<BoardView> views;
  for (int i = 0; i < 9; ++i) {
    const auto pose = PoseAt(board_, {0, 0, 0.2 * i}, {0.05 * (i % 3) - 0.05, 0.04 * (i / 3) - 0.04, 0.8});
    views.push_back(Seen(board_, BoardCamera(), pose, 0.1, random_));
  }

  const auto calibration = CalibrateIntrinsics(views, 640, 480);

  CHECK_FALSE(calibration.operator bool());
  LONGS_EQUAL(1, calibration.error().ExitCode());
  STRCMP_CONTAINS("do not determine the focal length (fu, fv)", calibration.error().detail.c_str());
  STRCMP_CONTAINS("tilt the board", calibration.error().detail.c_str());
}

TEST(IntrinsicCalibration, RefusesTooFewImagesAndSaysWhatBecameOfThem) {
  auto views = SeenBoards(board_, 6, 0.1, random_);
  for (const std::size_t i : {1U, 4U}) {
    views[i].corners.clear();
    views[i].fault = "no board found";
  }

  const auto calibration = CalibrateIntrinsics(views, 640, 480);

  CHECK_FALSE(calibration.operator bool());
  LONGS_EQUAL(1, calibration.error().ExitCode());
  STRCMP_EQUAL("4 of 6 images can be used (2: no board found); at least 5 are needed",
               calibration.error().detail.c_str());
}

TEST(IntrinsicCalibration, TakesABoardThatNeverAppearsForAWrongBoard) {
  const auto calibration = CalibrateIntrinsics({{"a.png", {}, "no board found"}}, 640, 480);

  CHECK_FALSE(calibration.operator bool());
  LONGS_EQUAL(2, calibration.error().ExitCode());
  STRCMP_EQUAL("--board", calibration.error().where.c_str());
}

TEST(IntrinsicCalibration, WarnsOfImageCornersThatTheBoardNeverReached) {
  std::vector<BoardView> views;
  for (const auto& pose : HeldBoards(board_, 16, 0.7, random_)) {
    auto far = pose;
    far.translation_m[2] += 0.4;
    views.push_back(Seen(board_, BoardCamera(), far, 0.05, random_));
  }

  const auto calibration = MustCalibrate(views);

  CHECK(Warns(calibration, "upper left, upper right, lower left, lower right"));
  CHECK(calibration.Coverage().Reach() < 0.8);
}
