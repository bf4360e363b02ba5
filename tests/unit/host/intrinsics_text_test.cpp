#include "host/intrinsics_text.h"

#include <opencv2/imgcodecs.hpp>

#include "firmware/base/yaml.h"
#include "firmware/optics/rig.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_board.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CoverageMap;

adit::host::IntrinsicCalibration Calibrated() {
  std::mt19937_64 random(3);
  return *adit::host::CalibrateIntrinsics(
      adit::tests::SeenBoards(adit::tests::SyntheticBoard(), 10, 0.1, random), 640, 480);
}

}  // namespace

TEST_GROUP(Coverage){};

TEST(Coverage, CountsCornersInCells) {
  CoverageMap map(640, 480);
  const std::array<Eigen::Vector2d, 4> corners{{{0, 0}, {79, 79}, {639, 479}, {320, 240}}};
  map.Add(corners);

  LONGS_EQUAL(2, map.Count(0, 0));
  LONGS_EQUAL(1, map.Count(7, 5));
  LONGS_EQUAL(1, map.Count(4, 3));
  DOUBLES_EQUAL(100.0 * 3 / 48, map.Pct(), 1e-9);
  DOUBLES_EQUAL(1, map.Reach(), 1e-9);
  LONGS_EQUAL(2, map.MissedCorners().size());
  STRCMP_EQUAL("upper right", map.MissedCorners()[0].c_str());
  STRCMP_EQUAL("lower left", map.MissedCorners()[1].c_str());
}

TEST(Coverage, IsDrawnInTheImagesSize) {
  const auto calibration = Calibrated();
  const auto png =
      adit::host::DrawCoverage(calibration.Coverage(), calibration.marks, {640, 480}, calibration.sigma0_px);

  const cv::Mat picture = cv::imdecode(png, cv::IMREAD_COLOR);
  LONGS_EQUAL(640, picture.cols);
  LONGS_EQUAL(480, picture.rows);
}

TEST_GROUP(IntrinsicsFile) { adit::tests::ScratchFolder folder_; };

TEST(IntrinsicsFile, IsReadAsACameraAndHoldsItsCovariance) {
  const auto calibration = Calibrated();
  const std::string path = folder_.Write("cam0.yaml", adit::host::FormatIntrinsics(calibration));

  const auto camera = adit::optics::LoadCamera(path);
  if (!camera) FAIL(camera.error().Line().c_str());
  CHECK((adit::host::Intrinsics(*camera) - adit::host::Intrinsics(calibration.camera)).norm() == 0);
  auto in = *adit::base::YamlReader::OpenFile(path);
  const auto sigma = in.Numbers("sigma", 8);
  const auto covariance = in.Matrix("covariance", 8, 8);
  CHECK(in.Ok());
  for (std::size_t i = 0; i < 8; ++i)
    DOUBLES_EQUAL(sigma[i] * sigma[i], covariance[9 * i], 1e-6 * covariance[9 * i]);
}

TEST(IntrinsicsFile, SaysInTheSummaryWhatBecameOfEveryImage) {
  auto calibration = Calibrated();
  calibration.images[3].left_out = "no board found";

  const std::string text = adit::host::Summary(calibration, adit::tests::SyntheticBoard());

  STRCMP_CONTAINS("9 of 10 used", text.c_str());
  STRCMP_CONTAINS("  3  left out: no board found\n", text.c_str());
  STRCMP_CONTAINS("apart by", text.c_str());
  STRCMP_CONTAINS("verdict", text.c_str());
}
