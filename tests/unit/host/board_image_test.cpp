#include "host/board_image.h"

#include <opencv2/imgcodecs.hpp>

#include "tests/support/scratch_folder.h"

#include <CppUTest/TestHarness.h>

TEST_GROUP(BoardImage) { adit::tests::ScratchFolder folder_; };

TEST(BoardImage, TakesAFolderForItsImagesByName) {
  folder_.Write("b.png", "");
  folder_.Write("a.JPG", "");
  folder_.Write("notes.txt", "");

  const auto images = adit::host::ListImages({folder_ / ""});

  LONGS_EQUAL(2, images->size());
  STRCMP_CONTAINS("a.JPG", (*images)[0].c_str());
}

TEST(BoardImage, RefusesMissingEmptyAndRepeatedPaths) {
  LONGS_EQUAL(2, adit::host::ListImages({folder_ / "none"}).error().ExitCode());
  STRCMP_CONTAINS("holds no images", adit::host::ListImages({folder_ / ""}).error().detail.c_str());
  const std::string path = folder_.Write("a.png", "");
  STRCMP_CONTAINS("named twice", adit::host::ListImages({path, folder_ / ""}).error().detail.c_str());
}

TEST(BoardImage, ReadsGreyAndColourAndSixteenBit) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", cv::Mat(12, 20, type, cv::Scalar::all(77)), bytes);
    const auto image =
        adit::host::ReadBoardImage(folder_.Write("a.png", std::string(bytes.begin(), bytes.end())));

    CHECK(image.operator bool());
    LONGS_EQUAL(1, image->channels());
    LONGS_EQUAL(20, image->cols);
    LONGS_EQUAL(type == CV_16UC1 ? CV_16U : CV_8U, image->depth());
  }
}

TEST(BoardImage, RefusesFilesThatWereCutShort) {
  for (const char* ending : {".png", ".jpg"}) {
    std::vector<unsigned char> bytes;
    cv::imencode(ending, cv::Mat(48, 64, CV_8U, cv::Scalar(77)), bytes);
    const std::string half(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2));
    const std::string path = folder_.Write(std::string("half") + ending, half);

    const auto image = adit::host::ReadBoardImage(path);
    CHECK_FALSE(image.operator bool());
    LONGS_EQUAL(2, image.error().ExitCode());
    STRCMP_EQUAL(path.c_str(), image.error().where.c_str());
  }
}
