// The segmentation against OpenCV's connected components.
#include "firmware/detect/components.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <tuple>
#include <vector>

#include "firmware/detect/row_scan.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::ImageView;
using adit::detect::Components;
using adit::detect::Run;

constexpr int kThreshold = 100;

ImageView ViewOf(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step),
          image.elemSize() == 1 ? 8 : 12};
}

/// Area and box of every component.
using Facts = std::vector<std::tuple<int, int, int, int, int>>;

Facts ByOpenCv(const cv::Mat& image) {
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(image > kThreshold, labels, stats, centroids, 8, CV_32S);
  Facts facts;
  for (int i = 1; i < count; ++i) {
    const int x = stats.at<int>(i, cv::CC_STAT_LEFT), y = stats.at<int>(i, cv::CC_STAT_TOP);
    facts.emplace_back(stats.at<int>(i, cv::CC_STAT_AREA), x, y, x + stats.at<int>(i, cv::CC_STAT_WIDTH) - 1,
                       y + stats.at<int>(i, cv::CC_STAT_HEIGHT) - 1);
  }
  std::sort(facts.begin(), facts.end());
  return facts;
}

Facts ByAdit(const cv::Mat& image) {
  static auto components = std::make_unique<Components>();
  CHECK(components->Segment(ViewOf(image), kThreshold));
  Facts facts;
  for (const auto& c : components->All()) {
    facts.emplace_back(static_cast<int>(c.area_px), c.x_min_px, c.y_min_px, c.x_max_px, c.y_max_px);
  }
  std::sort(facts.begin(), facts.end());
  return facts;
}

void CheckSame(const cv::Mat& image, const char* name) { CHECK_TEXT(ByAdit(image) == ByOpenCv(image), name); }

/// Every third pixel or so bright, with that probability.
cv::Mat Noise(int width, int height, double share, unsigned seed) {
  cv::Mat image(height, width, CV_8U);
  std::mt19937 random(seed);
  std::bernoulli_distribution bright(share);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at<std::uint8_t>(y, x) = bright(random) ? 200 : 50;
  }
  return image;
}

}  // namespace

TEST_GROUP(Components){};

TEST(Components, EqualOpenCvsOnNoiseOfEveryDensityAndWidth_Seeds1To60) {
  unsigned seed = 1;
  for (const double share : {0.01, 0.1, 0.3, 0.41, 0.5, 0.7, 0.95}) {
    for (const int width : {1, 2, 31, 63, 64, 65, 127, 128, 200, 321})
      CheckSame(Noise(width, 97, share, seed++), "noise");
  }
}

TEST(Components, EqualOpenCvsOnPatternsThatTearAtTheUnionFind) {
  cv::Mat comb(96, 256, CV_8U, cv::Scalar(0));
  for (int x = 0; x < 256; x += 2) comb.col(x).rowRange(0, 95).setTo(255);
  comb.row(95).setTo(255);
  CheckSame(comb, "comb joined at the bottom");
  cv::Mat checker(64, 130, CV_8U, cv::Scalar(0));
  for (int y = 0; y < 64; ++y) {
    for (int x = y % 2; x < 130; x += 2) checker.at<std::uint8_t>(y, x) = 255;
  }
  CheckSame(checker, "checkerboard: one by its diagonals");
  cv::Mat spiral(101, 101, CV_8U, cv::Scalar(0));
  for (int r = 2; r < 50; r += 4) {
    cv::rectangle(spiral, {50 - r, 50 - r}, {50 + r, 50 + r}, 255);
    cv::line(spiral, {50 + r, 50 + r}, {50 + r + 4, 50 + r}, 255);
    spiral.at<std::uint8_t>(50 - r + 1, 50 - r) = 0;
  }
  CheckSame(spiral, "spiral");
  CheckSame(cv::Mat(70, 200, CV_8U, cv::Scalar(255)), "all bright");
  CheckSame(cv::Mat(70, 200, CV_8U, cv::Scalar(kThreshold)), "all exactly at the threshold");
  cv::Mat diagonal = cv::Mat::eye(150, 150, CV_8U) * 255;
  CheckSame(diagonal, "diagonal");
  cv::Mat flipped;
  cv::flip(diagonal, flipped, 1);
  CheckSame(flipped, "other diagonal");
}

TEST(Components, EqualOpenCvsOnSixteenBits_Seed9) {
  cv::Mat image;
  Noise(130, 80, 0.4, 9).convertTo(image, CV_16U, 3);
  CHECK(ByAdit(image) == ByOpenCv(image));
}

TEST(Components, ReadAlongTheStride_Seed3) {
  const cv::Mat wide = Noise(300, 50, 0.4, 3);
  CheckSame(wide.colRange(17, 188), "part of a wider image");
}

TEST(Components, EveryRunBelongsToTheComponentThatHoldsIt_Seed4) {
  auto components = std::make_unique<Components>();
  const cv::Mat image = Noise(200, 100, 0.3, 4);
  CHECK(components->Segment(ViewOf(image), kThreshold));
  std::vector<std::uint32_t> area(components->All().size());
  for (std::size_t i = 0; i < components->Runs().size(); ++i) {
    const Run& run = components->Runs()[i];
    area[components->ComponentOf(i)] += static_cast<std::uint32_t>(run.end_px - run.begin_px);
  }
  for (std::size_t i = 0; i < area.size(); ++i) LONGS_EQUAL(components->All()[i].area_px, area[i]);
}

TEST(Components, TooManyRunsGiveNoneAtAll) {
  cv::Mat stripes(1024, 1400, CV_8U, cv::Scalar(0));
  for (int x = 0; x < 1400; x += 2) stripes.col(x).setTo(255);
  auto components = std::make_unique<Components>();
  CHECK(!components->Segment(ViewOf(stripes), kThreshold));
  LONGS_EQUAL(0, components->All().size());
  LONGS_EQUAL(0, components->Runs().size());
  CHECK(components->Segment(ViewOf(Noise(64, 64, 0.1, 1)), kThreshold));
  CHECK(!components->All().empty());
}

TEST_GROUP(RowScan){};

TEST(RowScan, TheFastestEqualsThePlainOneOnRowsOfEveryLength_Seed5) {
  std::mt19937 random(5);
  std::vector<std::uint8_t> row(400);
  std::vector<Run> plain(400), fast(400);
  for (int round = 0; round < 3000; ++round) {
    const int width = static_cast<int>(random() % 400);
    const int threshold = static_cast<int>(random() % 256);
    const std::size_t length = 1 + random() % 90;
    for (std::size_t x = 0; x < row.size(); ++x) {
      row[x] = static_cast<std::uint8_t>((x / length) % 2 == 0 ? static_cast<unsigned>(threshold)
                                                               : random() % 256);
    }
    const std::size_t count =
        adit::detect::ScanRowPlain(row.data(), width, threshold, plain.data(), plain.size());
    LONGS_EQUAL(count,
                adit::detect::FastestRowScan()(row.data(), width, threshold, fast.data(), fast.size()));
    for (std::size_t i = 0; i < count; ++i) {
      LONGS_EQUAL(plain[i].begin_px, fast[i].begin_px);
      LONGS_EQUAL(plain[i].end_px, fast[i].end_px);
    }
  }
}

TEST(RowScan, CountsRunsBeyondItsRoomWithoutWritingThem) {
  std::vector<std::uint8_t> row(64, 0);
  for (std::size_t x = 0; x < 64; x += 2) row[x] = 255;
  std::vector<Run> runs(3, Run{7, 7, 7});
  LONGS_EQUAL(32, adit::detect::FastestRowScan()(row.data(), 64, 100, runs.data(), 2));
  LONGS_EQUAL(7, runs[2].begin_px);
}
