#include "drivers/recording/recording.h"

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <thread>

#include "tests/support/scratch_folder.h"

#include <CppUTest/TestHarness.h>

using adit::base::ErrorCode;
using adit::base::ImageView;
using adit::base::Side;
using adit::recording::OpenRecording;
using adit::recording::ReadImage;
using adit::recording::RecordingWriter;
using adit::tests::ReadAll;
using adit::tests::ScratchFolder;

namespace {

constexpr int kWidthPx = 37, kHeightPx = 11;
constexpr unsigned kSeed = 20240917;

std::vector<std::uint16_t> RandomPixels(int bits) {
  std::mt19937 random(kSeed + static_cast<unsigned>(bits));
  std::vector<std::uint16_t> pixels;
  for (int i = 0; i < kWidthPx * kHeightPx; ++i)
    pixels.push_back(static_cast<std::uint16_t>(random() & ((1U << bits) - 1)));
  pixels[0] = 0;
  pixels[1] = static_cast<std::uint16_t>((1U << bits) - 1);
  return pixels;
}

ImageView WideView(const std::vector<std::uint16_t>& pixels, int bits) {
  return {reinterpret_cast<const std::uint8_t*>(pixels.data()), kWidthPx, kHeightPx, 2 * kWidthPx, bits};
}

/// A recording of two tiny pairs, whose left index tests may then spoil.
struct Pairs {
  ScratchFolder scratch;
  std::string folder = scratch / "rec";
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidthPx * kHeightPx, 7);

  Pairs() {
    auto writer = RecordingWriter::Create(folder, "left\n", "right\n");
    const ImageView view{pixels.data(), kWidthPx, kHeightPx, kWidthPx, 8};
    for (const Side side : {Side::kLeft, Side::kRight}) {
      CHECK_TRUE(static_cast<bool>(writer->Write(side, 1000, view)));
      CHECK_TRUE(static_cast<bool>(writer->Write(side, 2000, view)));
    }
    CHECK_TRUE(static_cast<bool>(writer->Finish()));
  }
  std::string LineOf(const std::string& index) {
    scratch.Write("rec/cam0/data.csv", index);
    const auto recording = OpenRecording(folder);
    return recording ? "opened" : recording.error().Line().substr(folder.size());
  }
};

}  // namespace

TEST_GROUP(Recording){};

TEST(Recording, ReturnsEveryPixelOf8Bit) {
  const ScratchFolder scratch;
  const auto wide = RandomPixels(8);
  const std::vector<std::uint8_t> pixels(wide.begin(), wide.end());
  auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  const ImageView view{pixels.data(), kWidthPx, kHeightPx, kWidthPx, 8};
  CHECK_TRUE(static_cast<bool>(writer->Write(Side::kLeft, 1'700'000'000'000'000'001, view)));
  CHECK_TRUE(static_cast<bool>(writer->Write(Side::kRight, 1'700'000'000'000'000'002, view)));
  CHECK_TRUE(static_cast<bool>(writer->Finish()));

  const auto recording = OpenRecording(scratch / "rec");
  CHECK_TRUE(static_cast<bool>(recording));
  LONGLONGS_EQUAL(1'700'000'000'000'000'001, recording->left.front().mid_exposure_ns);
  LONGLONGS_EQUAL(1'700'000'000'000'000'002, recording->right.front().mid_exposure_ns);
  const auto image = ReadImage(recording->left.front().path);
  LONGS_EQUAL(8, image->bits);
  LONGS_EQUAL(kWidthPx, image->width_px);
  LONGS_EQUAL(kHeightPx, image->height_px);
  CHECK_TRUE(image->pixels == pixels);
}

TEST(Recording, KeepsTheUpperBitsOf10And12BitAndSaturationStaysSaturation) {
  for (const int bits : {10, 12, 16}) {
    const ScratchFolder scratch;
    const auto pixels = RandomPixels(bits);
    auto writer = RecordingWriter::Create(scratch / "rec", "", "");
    CHECK_TRUE(static_cast<bool>(writer->Write(Side::kLeft, 5, WideView(pixels, bits))));
    const auto image = ReadImage(scratch / "rec/cam0/data/5.png");
    LONGS_EQUAL(16, image->bits);
    const auto* read = reinterpret_cast<const std::uint16_t*>(image->pixels.data());
    LONGS_EQUAL(0, read[0]);
    LONGS_EQUAL(65535, read[1]);
    for (std::size_t i = 0; i < pixels.size(); ++i) LONGS_EQUAL(pixels[i], read[i] >> (16 - bits));
  }
}

TEST(Recording, WritesRowsThatHaveGaps) {
  const ScratchFolder scratch;
  std::vector<std::uint8_t> pixels(50 * kHeightPx, 255);
  for (int y = 0; y < kHeightPx; ++y)
    for (int x = 0; x < kWidthPx; ++x)
      pixels[static_cast<std::size_t>(50 * y + x)] = static_cast<std::uint8_t>(x + y);
  auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  CHECK_TRUE(static_cast<bool>(writer->Write(Side::kLeft, 5, {pixels.data(), kWidthPx, kHeightPx, 50, 8})));
  const auto image = ReadImage(scratch / "rec/cam0/data/5.png");
  LONGS_EQUAL(kWidthPx - 1 + 4, image->pixels[4 * kWidthPx + kWidthPx - 1]);
}

TEST(Recording, HasTheLayoutOfEuRoC) {
  const Pairs pairs;
  STRCMP_EQUAL("#timestamp [ns],filename\n1000,1000.png\n2000,2000.png\n",
               ReadAll(pairs.folder + "/cam0/data.csv").c_str());
  STRCMP_EQUAL("left\n", ReadAll(pairs.folder + "/cam0/sensor.yaml").c_str());
  STRCMP_EQUAL("right\n", ReadAll(pairs.folder + "/cam1/sensor.yaml").c_str());
  CHECK_FALSE(cv::imread(pairs.folder + "/cam1/data/2000.png", cv::IMREAD_UNCHANGED).empty());
}

TEST(Recording, HasNoIndexBeforeItIsFinished) {
  const ScratchFolder scratch;
  {
    auto writer = RecordingWriter::Create(scratch / "rec", "", "");
    const std::vector<std::uint8_t> pixel{1};
    CHECK_TRUE(static_cast<bool>(writer->Write(Side::kLeft, 5, {pixel.data(), 1, 1, 1, 8})));
  }
  CHECK_FALSE(std::filesystem::exists(scratch / "rec/cam0/data.csv"));
  CHECK_FALSE(static_cast<bool>(OpenRecording(scratch / "rec")));
}

TEST(Recording, IsWrittenByTwoThreadsAtOnce) {
  const ScratchFolder scratch;
  auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  const std::vector<std::uint8_t> pixels(kWidthPx * kHeightPx, 9);
  const auto write_side = [&](Side side) {
    bool good = true;
    for (int i = 0; i < 30; ++i)
      good = good && writer->Write(side, i, {pixels.data(), kWidthPx, kHeightPx, kWidthPx, 8});
    return good;
  };
  bool right = false;
  std::thread thread([&] { right = write_side(Side::kRight); });
  const bool left = write_side(Side::kLeft);
  thread.join();
  CHECK_TRUE(left && right && writer->Finish());
  LONGS_EQUAL(30, OpenRecording(scratch / "rec")->right.size());
}

TEST(Recording, RefusesAFolderThatHoldsSomething) {
  const ScratchFolder scratch;
  scratch.Write("rec/notes.txt", "mine");
  const auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  CHECK_FALSE(static_cast<bool>(writer));
  CHECK_TRUE(writer.error().code == ErrorCode::kUsage);
  STRCMP_EQUAL("mine", ReadAll(scratch / "rec/notes.txt").c_str());
}

TEST(Recording, RefusesFramesThatDoNotGetLater) {
  const ScratchFolder scratch;
  auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  const std::vector<std::uint8_t> pixel{1};
  const ImageView view{pixel.data(), 1, 1, 1, 8};
  CHECK_TRUE(static_cast<bool>(writer->Write(Side::kLeft, 5, view)));
  CHECK_FALSE(static_cast<bool>(writer->Write(Side::kLeft, 5, view)));
  CHECK_FALSE(static_cast<bool>(writer->Write(Side::kRight, -1, view)));
  CHECK_TRUE(static_cast<bool>(writer->Write(Side::kRight, 5, view)));
}

TEST(Recording, NamesTheFileThatCannotBeWritten) {
  const ScratchFolder scratch;
  auto writer = RecordingWriter::Create(scratch / "rec", "", "");
  std::filesystem::remove_all(scratch / "rec/cam0/data");
  const std::vector<std::uint8_t> pixel{1};
  const auto written = writer->Write(Side::kLeft, 5, {pixel.data(), 1, 1, 1, 8});
  CHECK_FALSE(static_cast<bool>(written));
  STRCMP_CONTAINS("rec/cam0/data/5.png", written.error().Line().c_str());
}

TEST(Recording, ReadsCommentsBlankLinesSpacesAndCrLf) {
  Pairs pairs;
  STRCMP_EQUAL(
      "opened",
      pairs.LineOf("#timestamp [ns],filename\r\n\r\n# by hand\r\n1000, 1000.png\r\n2000,2000.png").c_str());
}

TEST(Recording, NamesFileAndLineOfWhatItRefuses) {
  Pairs pairs;
  pairs.scratch.Write("rec/outside.png", "");
  const std::pair<const char*, const char*> cases[] = {
      {"#t\n1000,1000.png\n900,2000.png\n", "/cam0/data.csv:3: has the time 900"},
      {"1000,1000.png\n1000,2000.png\n", "/cam0/data.csv:2: has the time 1000"},
      {"1000;1000.png\n", "/cam0/data.csv:1: is '1000;1000.png'"},
      {"1000.5,1000.png\n", "/cam0/data.csv:1: is '1000.5,1000.png'"},
      {"abc,1000.png\n", "/cam0/data.csv:1: is 'abc,1000.png'"},
      {"-5,1000.png\n", "/cam0/data.csv:1: is '-5,1000.png'"},
      {"99999999999999999999,1000.png\n", "/cam0/data.csv:1: is '99999999999999999999"},
      {",1000.png\n", "/cam0/data.csv:1: is ',1000.png'"},
      {"1000,\n", "/cam0/data.csv:1: names ''"},
      {"1000,../../outside.png\n", "/cam0/data.csv:1: names '../../outside.png'"},
      {"1000,..\n", "/cam0/data.csv:1: names '..'"},
      {"1000,1000.png,extra\n", "/cam0/data.csv:1: names '1000.png,extra'"},
      {"1000,1000.png\n2000,missing.png\n", "missing.png, which is not there"},
      {"#only a comment\n", "/cam0/data.csv: holds no images"},
      {"", "/cam0/data.csv: holds no images"},
  };
  for (const auto& [index, said] : cases) STRCMP_CONTAINS(said, pairs.LineOf(index).c_str());
  std::string bytes("1000,1000.png\0\n", 15);
  STRCMP_CONTAINS("/cam0/data.csv:1", pairs.LineOf(bytes).c_str());
}

TEST(Recording, RefusesAFolderThatIsNotThereAndOneWithASingleCamera) {
  const Pairs pairs;
  CHECK_TRUE(OpenRecording(pairs.scratch / "nowhere").error().code == ErrorCode::kNotFound);
  std::filesystem::remove_all(pairs.folder + "/cam1");
  STRCMP_CONTAINS("cam1/data.csv", OpenRecording(pairs.folder).error().Line().c_str());
}

TEST(Recording, RefusesImagesThatAreNoneOrCutOrColoured) {
  const Pairs pairs;
  const std::string whole = ReadAll(pairs.folder + "/cam0/data/1000.png");
  const cv::Mat colours(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  cv::imwrite(pairs.scratch / "colours.png", colours);
  const std::string paths[] = {pairs.scratch.Write("empty.png", ""),
                               pairs.scratch.Write("text.png", "no image"),
                               pairs.scratch.Write("cut.png", whole.substr(0, whole.size() / 2)),
                               pairs.scratch / "colours.png",
                               pairs.scratch / "nowhere.png",
                               pairs.folder};
  for (const std::string& path : paths) {
    const auto image = ReadImage(path);
    CHECK_FALSE(static_cast<bool>(image));
    STRCMP_EQUAL(path.c_str(), image.error().where.c_str());
  }
}
