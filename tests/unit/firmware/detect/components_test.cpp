// The segmentation against OpenCV's connected components.
#include "firmware/detect/components.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <tuple>
#include <vector>

#include "firmware/detect/row_scan.h"
#include "tests/support/opencv_view.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::ImageView;
using adit::detect::Components;
using adit::detect::LitWord;
using adit::detect::Run;
using adit::support::ViewOf;
using adit::support::WholeOf;

constexpr int kThreshold = 100;

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
  CHECK(components->Segment(ViewOf(image), WholeOf(ViewOf(image)), kThreshold));
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

TEST_GROUP(Components){// ThreadSanitizer does not see how OpenCV's own threads take turns.
                       TEST_SETUP(){cv::setNumThreads(1);
}
}
;

TEST(Components, EqualOpenCvsOnNoiseOfEveryDensityAndWidth_Seeds1To60) {
  unsigned seed = 1;
  for (const double share : {0.01, 0.1, 0.3, 0.41, 0.5, 0.7, 0.95}) {
    for (const int width : {1, 2, 31, 63, 64, 65, 127, 128, 200, 321})
      CheckSame(Noise(width, 97, share, seed++), "noise");
  }
}

/// The image is read in bands: some of them are empty, or shorter than the others.
TEST(Components, EqualOpenCvsOnImagesOfFewRows_Seeds61To78) {
  unsigned seed = 61;
  for (int height = 1; height <= 9; ++height) {
    CheckSame(Noise(300, height, 0.3, seed++), "few rows");
    CheckSame(Noise(1400, height, 0.001, seed++), "few rows, mostly dark");
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

TEST(Components, TheirRunsAreTheirPixelsEachOnce_Seeds4To6) {
  auto components = std::make_unique<Components>();
  unsigned seed = 3;
  for (const double share : {0.3, 0.45, 0.8}) {
    const cv::Mat image = Noise(200, 100, share, ++seed);
    CHECK(components->Segment(ViewOf(image), WholeOf(ViewOf(image)), kThreshold));
    cv::Mat labels, seen(image.size(), CV_32S, cv::Scalar(0));
    cv::connectedComponents(image > kThreshold, labels, 8, CV_32S);
    for (const auto& c : components->All()) {
      int label = 0;
      std::uint32_t area_px = 0;
      for (const Run& run : components->RunsOf(c)) {
        if (label == 0) label = labels.at<int>(run.y_px, run.begin_px);
        for (int x = run.begin_px; x < run.end_px; ++x) {
          LONGS_EQUAL(label, labels.at<int>(run.y_px, x));
          ++seen.at<int>(run.y_px, x);
          ++area_px;
        }
      }
      LONGS_EQUAL(c.area_px, area_px);
    }
    CHECK(cv::countNonZero((seen == 1) != (image > kThreshold)) == 0);
  }
}

TEST(Components, ComeInTheOrderOfTheirFirstPixels_Seed7) {
  auto components = std::make_unique<Components>();
  CHECK(components->Segment(ViewOf(Noise(200, 100, 0.4, 7)), WholeOf(ViewOf(Noise(200, 100, 0.4, 7))),
                            kThreshold));
  const auto all = components->All();
  CHECK(all.size() > 20);
  for (std::size_t i = 1; i < all.size(); ++i) CHECK(all[i].y_min_px >= all[i - 1].y_min_px);
}

TEST(Components, InAWindowTheyAreThoseOfTheImageCutOutInTheImagesPlaces_Seed8) {
  auto components = std::make_unique<Components>();
  const cv::Mat image = Noise(300, 120, 0.35, 8);
  for (const cv::Rect cut : {cv::Rect(0, 0, 300, 120), cv::Rect(17, 9, 64, 40), cv::Rect(150, 50, 150, 70),
                             cv::Rect(299, 119, 1, 1), cv::Rect(100, 30, 129, 1)}) {
    const adit::detect::Window window{cut.x, cut.y, cut.x + cut.width - 1, cut.y + cut.height - 1};
    CHECK(components->Segment(ViewOf(image), window, kThreshold));
    Facts facts;
    for (const auto& c : components->All()) {
      facts.emplace_back(static_cast<int>(c.area_px), c.x_min_px - cut.x, c.y_min_px - cut.y,
                         c.x_max_px - cut.x, c.y_max_px - cut.y);
    }
    std::sort(facts.begin(), facts.end());
    CHECK(facts == ByOpenCv(image(cut)));
  }
}

/// A few bright blocks far apart, as dark rows are passed over many at a time.
TEST(Components, EqualOpenCvsWhereMostRowsAreDark_Seed10) {
  std::mt19937 random(10);
  for (int round = 0; round < 40; ++round) {
    cv::Mat image(200, 1 + static_cast<int>(random() % 700), CV_8U, cv::Scalar(50));
    for (int i = 0; i < 4; ++i) {
      const cv::Rect box(static_cast<int>(random() % static_cast<unsigned>(image.cols)),
                         static_cast<int>(random() % 200), 1 + static_cast<int>(random() % 9),
                         1 + static_cast<int>(random() % 9));
      image(box & cv::Rect({}, image.size())).setTo(200);
    }
    CheckSame(image, "few lit rows");
  }
}

TEST(Components, TooManyRunsGiveNoneAtAll) {
  cv::Mat stripes(1024, 1400, CV_8U, cv::Scalar(0));
  for (int x = 0; x < 1400; x += 2) stripes.col(x).setTo(255);
  auto components = std::make_unique<Components>();
  CHECK(!components->Segment(ViewOf(stripes), WholeOf(ViewOf(stripes)), kThreshold));
  LONGS_EQUAL(0, components->All().size());
  CHECK(
      components->Segment(ViewOf(Noise(64, 64, 0.1, 1)), WholeOf(ViewOf(Noise(64, 64, 0.1, 1))), kThreshold));
  CHECK(!components->All().empty());
}

TEST_GROUP(RowScan) {
  std::mt19937 random{5};

  /// Rows with dark and lit stretches, at the threshold and about it, against the plain loop.
  template <typename Pixel>
  void CompareWithPlain(adit::detect::RowScan plain, unsigned levels) {
    constexpr int kLongest = 1400, kSlack = 3;
    std::vector<Pixel> row(kLongest);
    std::vector<LitWord> slow(adit::detect::LitWordsRoom(kLongest)), fast(slow.size());
    for (int round = 0; round < 3000; ++round) {
      const int width = static_cast<int>(random() % (kLongest - kSlack + 1));
      const unsigned threshold = static_cast<unsigned>(random() % levels);
      const std::size_t length = 1 + random() % 400;
      for (std::size_t x = 0; x < row.size(); ++x)
        row[x] = static_cast<Pixel>((x / length) % 2 == 0 ? threshold : random() % levels);
      // Rows begin anywhere in memory.
      const auto* const at = reinterpret_cast<const std::uint8_t*>(row.data() + round % kSlack);
      const std::size_t words = plain(at, width, static_cast<int>(threshold), slow.data());
      const auto scan = adit::detect::FastestRowScan(sizeof(Pixel));
      LONGS_EQUAL(words, scan(at, width, static_cast<int>(threshold), fast.data()));
      for (std::size_t i = 0; i < words; ++i) {
        CHECK(slow[i].bright == fast[i].bright);
        LONGS_EQUAL(slow[i].first_px, fast[i].first_px);
      }
    }
  }

  /// A long dark stretch of several places, at the threshold and below it, with one pixel brighter anywhere,
  /// or none.
  template <typename Pixel>
  void CheckDarkScan(unsigned levels) {
    constexpr std::size_t kLongest = 5000, kSlack = 3;
    const auto scan = adit::detect::FastestDarkScan(sizeof(Pixel));
    for (int round = 0; round < 2000; ++round) {
      const auto threshold = static_cast<unsigned>(random() % (levels - 1));
      std::array<std::vector<Pixel>, adit::detect::kBands> places;
      for (auto& pixels : places) {
        pixels.resize(kLongest);
        for (Pixel& pixel : pixels) pixel = static_cast<Pixel>(random() % (threshold + 1));
      }
      const std::size_t first = random() % kSlack, count = random() % (kLongest - first);
      const std::size_t lit = first + random() % kLongest;
      if (lit < kLongest)
        places[random() % places.size()][lit] =
            static_cast<Pixel>(threshold + 1 + random() % (levels - 1 - threshold));
      adit::detect::Bands at;
      std::transform(places.begin(), places.end(), at.begin(), [&](const auto& pixels) {
        return reinterpret_cast<const std::uint8_t*>(pixels.data() + first);
      });
      const std::size_t dark = scan(at, count * sizeof(Pixel), static_cast<int>(threshold));
      const std::size_t known = std::min(count, lit - first);
      CHECK(dark <= known * sizeof(Pixel));
      // It stops less than a block before.
      constexpr std::size_t kBlockBytes = 256;
      CHECK(known * sizeof(Pixel) < dark + kBlockBytes);
    }
  }
};

TEST(RowScan, DarkStretchesArePassedOverUpToTheFirstLitPixel_Seed5) {
  CheckDarkScan<std::uint8_t>(256);
  CheckDarkScan<std::uint16_t>(4096);
  CheckDarkScan<std::uint16_t>(65536);
}

TEST(RowScan, TheFastestEqualsThePlainOneOnRowsOfEveryLength_Seed5) {
  CompareWithPlain<std::uint8_t>(adit::detect::ScanRowPlain8, 256);
  CompareWithPlain<std::uint16_t>(adit::detect::ScanRowPlain16, 4096);
  CompareWithPlain<std::uint16_t>(adit::detect::ScanRowPlain16, 65536);
}

TEST(RowScan, ThePlainOneSetsTheBitsOfWhatIsBrighterInTheWordsThatHoldAny) {
  std::vector<std::uint8_t> row(200, 100);
  row[0] = 101, row[63] = 255, row[128] = 200, row[133] = 101;
  std::vector<LitWord> lit(adit::detect::LitWordsRoom(200));
  LONGS_EQUAL(2, adit::detect::ScanRowPlain8(row.data(), 200, 100, lit.data()));
  CHECK(lit[0].bright == (1ULL | 1ULL << 63));
  LONGS_EQUAL(0, lit[0].first_px);
  CHECK(lit[1].bright == (1ULL | 1ULL << 5));
  LONGS_EQUAL(128, lit[1].first_px);
  LONGS_EQUAL(0, adit::detect::ScanRowPlain8(row.data() + 1, 62, 100, lit.data()));
}

TEST(RowScan, EdgesAreWhereTheBitsChange_Seed6) {
  for (int round = 0; round < 3000; ++round) {
    const int width = 1 + static_cast<int>(random() % 300);
    const std::size_t length = 1 + random() % 130;
    std::vector<std::uint64_t> bright(adit::detect::LitWordsRoom(width));
    std::vector<std::uint16_t> expected, edges(adit::detect::RowEdgesRoom(width));
    bool lit = false;
    for (int x = 0; x < width; ++x) {
      const bool now = static_cast<std::size_t>(x) / length % 2 == 0 ? random() % 2 == 0 : lit;
      if (now) bright[static_cast<std::size_t>(x) / 64] |= 1ULL << (x % 64);
      if (now != lit) expected.push_back(static_cast<std::uint16_t>(x));
      lit = now;
    }
    if (lit) expected.push_back(static_cast<std::uint16_t>(width));
    std::vector<LitWord> words;
    for (std::size_t i = 0; i < bright.size(); ++i) {
      if (bright[i] != 0) words.push_back({bright[i], static_cast<std::uint32_t>(64 * i)});
    }
    edges.resize(adit::detect::RowEdges(words, edges.data()));
    CHECK(edges == expected);
  }
}
