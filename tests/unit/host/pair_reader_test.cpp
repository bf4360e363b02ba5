#include "host/pair_reader.h"

#include <filesystem>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::Side;
using adit::base::TimeNs;
using adit::host::ImageSize;
using adit::host::PairReader;

constexpr int kWidthPx = 32, kHeightPx = 16;
const char* const kSensor =
    "camera_model: pinhole\nintrinsics: [100, 100, 16, 8]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [0, 0, 0, 0]\nresolution: [32, 16]\n";

/// A recording whose images are all of one grey value, the number of the image.
std::string Recorded(const std::vector<TimeNs>& left_ns, const std::vector<TimeNs>& right_ns,
                     int width_px = kWidthPx) {
  const std::string folder = (std::filesystem::temp_directory_path() / "adit_pair_reader_test").string();
  std::filesystem::remove_all(folder);
  auto writer = *adit::recording::RecordingWriter::Create(folder, kSensor, kSensor);
  const auto write = [&](Side side, const std::vector<TimeNs>& times_ns) {
    for (std::size_t i = 0; i < times_ns.size(); ++i) {
      const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width_px * kHeightPx),
                                             static_cast<std::uint8_t>(i));
      CHECK_TRUE(!!writer.Write(side, times_ns[i], {pixels.data(), width_px, kHeightPx, width_px, 8}));
    }
  };
  write(Side::kLeft, left_ns);
  write(Side::kRight, right_ns);
  CHECK_TRUE(!!writer.Finish());
  return folder;
}

adit::base::Result<PairReader> Open(const std::string& folder) {
  const ImageSize size{kWidthPx, kHeightPx, "rig.yaml"};
  return PairReader::Open(folder, size, size);
}

std::vector<TimeNs> Times(std::size_t count) {
  std::vector<TimeNs> times_ns;
  for (std::size_t i = 0; i < count; ++i)
    times_ns.push_back(1'000'000'000 + 16'666'667 * static_cast<TimeNs>(i));
  return times_ns;
}

}  // namespace

TEST_GROUP(PairReader) {
  std::string folder_;
  void teardown() override { std::filesystem::remove_all(folder_); }
};

TEST(PairReader, HandsOutAllPairsInOrder) {
  folder_ = Recorded(Times(10), Times(10));
  auto reader = Open(folder_);
  CHECK_TRUE(!!reader);
  for (std::size_t i = 0; i < 10; ++i) {
    const auto pair = reader->Next();
    CHECK((*pair)->mid_exposure_ns == Times(10)[i]);
    LONGS_EQUAL(i, (*pair)->trigger);
    LONGS_EQUAL(i, (*pair)->Frame(Side::kLeft).image.Row(3)[5]);
    LONGS_EQUAL(i, (*pair)->Frame(Side::kRight).image.Row(3)[5]);
    CHECK((*pair)->Frame(Side::kRight).stamp.side == Side::kRight);
  }
  CHECK_FALSE(reader->Next()->has_value());
  CHECK_FALSE(reader->Next()->has_value());
}

TEST(PairReader, LosesOneImageAndThatPairOnly) {
  auto left_ns = Times(6), right_ns = Times(6);
  left_ns.erase(left_ns.begin() + 1);
  right_ns.erase(right_ns.begin() + 4);
  for (TimeNs& time_ns : right_ns) time_ns += 200'000;  // one camera's clock is late

  folder_ = Recorded(left_ns, right_ns);
  auto reader = Open(folder_);

  LONGS_EQUAL(4, reader->Pairs());
  LONGS_EQUAL(2, reader->Unpaired());
  for (const std::size_t frame : {0U, 2U, 3U, 5U}) {
    CHECK((*reader->Next())->mid_exposure_ns == Times(6)[frame]);
  }
}

TEST(PairReader, DeclinesImagesOfAnotherSizeAndNamesThem) {
  folder_ = Recorded(Times(1), Times(1), 24);
  const auto pair = Open(folder_)->Next();
  CHECK_FALSE(pair);
  const std::string line = pair.error().Line();
  CHECK(line.find(".png: is 24 x 16 px; rig.yaml says 32 x 16 px for cam0") != std::string::npos);
  LONGS_EQUAL(2, pair.error().ExitCode());
}

TEST(PairReader, HandsOutTwelveBitsAsTheCameraDeliveredThem) {
  folder_ = (std::filesystem::temp_directory_path() / "adit_pair_reader_test").string();
  std::filesystem::remove_all(folder_);
  auto writer = *adit::recording::RecordingWriter::Create(folder_, kSensor, kSensor);
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(kWidthPx * kHeightPx));
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint16_t>((i * 97) % 4096);
  pixels[0] = 4095;
  const adit::base::ImageView view{reinterpret_cast<const std::uint8_t*>(pixels.data()), kWidthPx, kHeightPx,
                                   2 * kWidthPx, 12};
  for (const Side side : {Side::kLeft, Side::kRight}) CHECK_TRUE(!!writer.Write(side, 1'000'000'000, view));
  CHECK_TRUE(!!writer.Finish());

  const auto pair = Open(folder_)->Next();

  const auto image = (*pair)->Frame(Side::kRight).image;
  LONGS_EQUAL(12, image.bits);
  MEMCMP_EQUAL(pixels.data(), image.data, pixels.size() * 2);
}

TEST(PairReader, DeclinesAMissingImage) {
  folder_ = Recorded(Times(2), Times(2));
  std::filesystem::remove(folder_ + "/cam1/data/" + std::to_string(Times(2)[0]) + ".png");
  auto reader = Open(folder_);
  CHECK_FALSE(reader && reader->Next());
}

TEST(PairReader, DeclinesARecordingWithoutPairsAndNoRecording) {
  folder_ = Recorded({1'000'000'000}, {2'000'000'000});
  CHECK(Open(folder_).error().Line().find("holds no two images of one trigger (1 left, 1 right)") !=
        std::string::npos);
  CHECK_FALSE(Open("/nowhere"));
}
