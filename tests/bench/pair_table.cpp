// What a pair costs beside reading its images and beside OpenCV's segmentation of them: all in one run, in
// turn, frame by frame, each on another pair, so that all images come from memory. Medians of ratios: the
// machine's weather cancels, but that memory may be slow while the processor is not: no pair is faster beside
// the contours than reading is (contours/read). Once with the images in ordinary pages of memory, once in
// huge ones. Usage: pair_table [table.json]
#include <atomic>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "firmware/base/require.h"
#include "firmware/pipeline/pipeline.h"
#include "tests/bench/bench_frames.h"
#include "tests/bench/opencv_segmentation.h"
#include "tests/bench/read_bound.h"
#include "tests/bench/stopwatch.h"

namespace {

using adit::base::Side;
using adit::bench::ImagePair;
using adit::bench::InPages;
using adit::bench::Median;
using adit::bench::Pages;
using adit::bench::TimeUs;

constexpr int kPairs = 64;  // 183 MB: more than any cache holds
constexpr int kPasses = 8;  // and one before them that is not counted
constexpr std::size_t kBars = 2;
constexpr int kScenarios[] = {0, 20, 60, 200};
constexpr adit::base::DurationNs kPeriodNs = adit::base::kNsPerS / 60;
constexpr int kComponentsEvery = 8;  // it takes a hundred times as long

/// Detects right images in a thread of its own, handed over by a counter that both sides spin on.
class SecondCore {
 public:
  SecondCore(adit::pipeline::Pipeline& pipeline, adit::detect::BlobSet& out)
      : pipeline_(pipeline), out_(out), thread_([this] { Run(); }) {}
  ~SecondCore() {
    stop_.store(true, std::memory_order_relaxed);  // relaxed: nothing is published through it
    thread_.join();
  }
  void Start(const adit::base::CameraFrame& frame) {
    frame_ = frame;
    asked_.store(++asked_count_, std::memory_order_release);  // release: publishes frame_
  }
  void Wait() const {
    while (done_.load(std::memory_order_acquire) != asked_count_) {  // acquire: the blobs are complete
    }
  }

 private:
  void Run() {
    std::uint64_t done = 0;
    while (!stop_.load(std::memory_order_relaxed)) {
      if (asked_.load(std::memory_order_acquire) == done) continue;  // acquire: pairs with Start
      pipeline_.Detect(frame_, out_);
      done_.store(++done, std::memory_order_release);  // release: publishes the blobs
    }
  }
  adit::pipeline::Pipeline& pipeline_;
  adit::detect::BlobSet& out_;
  adit::base::CameraFrame frame_;
  std::uint64_t asked_count_ = 0;
  std::atomic<std::uint64_t> asked_{0}, done_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// The product on one pair, by one core or two.
class Product {
 public:
  Product(const adit::bench::Stage& stage, bool windows)
      : pipeline_(
            *adit::pipeline::Pipeline::Make(stage.rig, stage.models, {.detector = {}, .windows = windows})) {}

  void OneCore(const ImagePair& pair) {
    time_ += kPeriodNs;
    pipeline_.Detect(pair.Frame(Side::kLeft, time_), *left_);
    pipeline_.Detect(pair.Frame(Side::kRight, time_), *right_);
    pipeline_.Locate(*left_, *right_, *result_);
  }
  void TwoCores(SecondCore& second, const ImagePair& pair) {
    time_ += kPeriodNs;
    second.Start(pair.Frame(Side::kRight, time_));
    pipeline_.Detect(pair.Frame(Side::kLeft, time_), *left_);
    second.Wait();
    pipeline_.Locate(*left_, *right_, *result_);
  }
  int Tracked() const {
    int tracked = 0;
    for (const auto& target : result_->points.targets)
      tracked += target.status == adit::stereo::FixStatus::kTracked ? 1 : 0;
    return tracked;
  }
  bool Whole() const { return left_->whole; }
  std::unique_ptr<SecondCore> OpenSecondCore() { return std::make_unique<SecondCore>(pipeline_, *right_); }

 private:
  adit::pipeline::Pipeline pipeline_;
  std::unique_ptr<adit::detect::BlobSet> left_ = std::make_unique<adit::detect::BlobSet>();
  std::unique_ptr<adit::detect::BlobSet> right_ = std::make_unique<adit::detect::BlobSet>();
  std::unique_ptr<adit::pipeline::PairResult> result_ = std::make_unique<adit::pipeline::PairResult>();
  adit::base::TimeNs time_ = 0;
};

struct Row {
  std::string scenario;
  std::vector<double> pair_us, read_us, contours_us, components_us, two_us;
  std::vector<double> pair_over_read, contours_over_pair, contours_over_read, components_over_pair,
      two_over_one;
  int tracked = 0, sought = 0;
};

Row MeasureScenario(int lamps, const std::vector<ImagePair>& pairs) {
  Product product(adit::bench::MakeStage(kBars), false);
  Row row;
  row.scenario = "lamps_" + std::to_string(lamps);
  std::size_t sink = 0;
  for (int i = 0; i < kPairs * (kPasses + 1); ++i) {
    // Each method takes a pair that the others had long ago.
    const auto turn = [&](int ahead) -> const ImagePair& {
      return pairs[static_cast<std::size_t>((i + ahead) % kPairs)];
    };
    const double read_us = TimeUs([&] {
      sink += adit::bench::ReadAll(turn(0).left.Pixels()) + adit::bench::ReadAll(turn(0).right.Pixels());
    });
    const double pair_us = TimeUs([&] { product.OneCore(turn(16)); });
    const int tracked = product.Tracked();
    const double contours_us = TimeUs([&] {
      sink += adit::bench::SegmentByContours(turn(32).left.Pixels()) +
              adit::bench::SegmentByContours(turn(32).right.Pixels());
    });
    if (i < kPairs) continue;  // the first pass fills tables and caches
    row.tracked += tracked, row.sought += static_cast<int>(kBars);
    row.read_us.push_back(read_us), row.pair_us.push_back(pair_us), row.contours_us.push_back(contours_us);
    row.pair_over_read.push_back(pair_us / read_us), row.contours_over_pair.push_back(contours_us / pair_us);
    row.contours_over_read.push_back(contours_us / read_us);
    if (i % kComponentsEvery != 0) continue;
    row.components_us.push_back(TimeUs([&] {
      sink += adit::bench::SegmentByComponents(turn(48).left.Pixels()) +
              adit::bench::SegmentByComponents(turn(48).right.Pixels());
    }));
    row.components_over_pair.push_back(row.components_us.back() / pair_us);
  }
  // Apart from the rest: while the second core spins, it is in everybody's way.
  const auto second = product.OpenSecondCore();
  for (int i = 0; i < kPairs * kPasses; ++i) {
    const double one_us = TimeUs([&] { product.OneCore(pairs[static_cast<std::size_t>(i % kPairs)]); });
    const ImagePair& other = pairs[static_cast<std::size_t>((i + kPairs / 2) % kPairs)];
    row.two_us.push_back(TimeUs([&] { product.TwoCores(*second, other); }));
    row.two_over_one.push_back(row.two_us.back() / one_us);
  }
  ADIT_REQUIRE(sink > 0);
  return row;
}

/// Following: four targets that are known from the pair before, sixty lamps.
struct Following {
  double pair_us = 0, read_us = 0;  ///< means: most pairs are cheap, one in fifteen is not
  std::vector<double> whole_us, windows_us;
  double tracked = 0;  ///< share of the targets
};

constexpr std::size_t kFollowed = 4;
constexpr int kLampsFollowing = 60;

Following MeasureFollowing(const std::vector<ImagePair>& pairs) {
  Product product(adit::bench::MakeStage(kFollowed), true);
  Following sums;
  std::size_t sink = 0;
  for (int i = 0; i < kPairs * (kPasses + 1); ++i) {
    const auto turn = [&](int ahead) -> const ImagePair& {
      return pairs[static_cast<std::size_t>((i + ahead) % kPairs)];
    };
    const double read_us = TimeUs([&] {
      sink += adit::bench::ReadAll(turn(0).left.Pixels()) + adit::bench::ReadAll(turn(0).right.Pixels());
    });
    const double pair_us = TimeUs([&] { product.OneCore(turn(kPairs / 2)); });
    if (i < kPairs) continue;
    constexpr double kCount = kPairs * kPasses;
    sums.read_us += read_us / kCount, sums.pair_us += pair_us / kCount;
    (product.Whole() ? sums.whole_us : sums.windows_us).push_back(pair_us);
    sums.tracked += product.Tracked() / (kCount * kFollowed);
  }
  ADIT_REQUIRE(sink > 0);
  return sums;
}

std::string Json(const Row& row) {
  std::ostringstream out;
  out << "    {\"scenario\": \"" << row.scenario << "\", \"pair_us\": " << Median(row.pair_us)
      << ", \"read_us\": " << Median(row.read_us) << ", \"opencv_contours_us\": " << Median(row.contours_us)
      << ", \"opencv_components_us\": " << Median(row.components_us)
      << ", \"two_cores_us\": " << Median(row.two_us)
      << ", \"pair_over_read\": " << Median(row.pair_over_read)
      << ", \"opencv_contours_over_pair\": " << Median(row.contours_over_pair)
      << ", \"opencv_contours_over_read\": " << Median(row.contours_over_read)
      << ", \"opencv_components_over_pair\": " << Median(row.components_over_pair)
      << ", \"two_cores_over_one\": " << Median(row.two_over_one) << ", \"targets_tracked\": " << row.tracked
      << ", \"targets_sought\": " << row.sought << "}";
  return out.str();
}

std::string Json(const Following& following) {
  std::ostringstream out;
  out << "{\"targets\": " << kFollowed << ", \"lamps\": " << kLampsFollowing
      << ", \"pair_us\": " << following.pair_us << ", \"read_us\": " << following.read_us
      << ", \"windows_us\": " << Median(following.windows_us)
      << ", \"whole_us\": " << Median(following.whole_us)
      << ", \"pair_over_read\": " << following.pair_us / following.read_us
      << ", \"tracked\": " << following.tracked << "}";
  return out.str();
}

void Print(const Row& row) {
  std::printf("%-10s %9.0f %9.0f %12.0f %11.0f | %10.2f %14.2f %14.2f %16.1f %9.2f | %d of %d\n",
              row.scenario.c_str(), Median(row.pair_us), Median(row.read_us), Median(row.contours_us),
              Median(row.two_us), Median(row.pair_over_read), Median(row.contours_over_pair),
              Median(row.contours_over_read), Median(row.components_over_pair), Median(row.two_over_one),
              row.tracked, row.sought);
  std::fflush(stdout);
}

void Print(const Following& following) {
  std::printf(
      "following %zu targets among %d lamps: a pair in windows %.0f us, all over %.0f us, mean %.0f us; "
      "read %.0f us; ratio of the means %.2f, %.1f %% tracked\n",
      kFollowed, kLampsFollowing, Median(following.windows_us), Median(following.whole_us), following.pair_us,
      following.read_us, following.pair_us / following.read_us, 100 * following.tracked);
}

/// Prints the table of one kind of pages. Returns its members of the JSON object.
std::string MeasureIn(Pages pages) {
  const bool huge = pages == Pages::kHuge;
  std::printf("images in %s pages\n%-10s %9s %9s %12s %11s | %10s %14s %14s %16s %9s | %s\n",
              huge ? "huge" : "ordinary", "scenario", "pair us", "read us", "contours us", "2 cores us",
              "pair/read", "contours/pair", "contours/read", "components/pair", "2/1 cores", "tracked");
  std::string json = huge ? "\"pairs_huge_pages\": [\n" : "\"pairs\": [\n";
  for (const int lamps : kScenarios) {
    const Row row = MeasureScenario(lamps, InPages(adit::bench::RenderDrive(kPairs, kBars, lamps, 1), pages));
    Print(row);
    json += (lamps == kScenarios[0] ? "" : ",\n") + Json(row);
  }
  const Following following =
      MeasureFollowing(InPages(adit::bench::RenderDrive(kPairs, kFollowed, kLampsFollowing, 1), pages));
  Print(following);
  return json + (huge ? "\n],\n\"following_huge_pages\": " : "\n],\n\"following\": ") + Json(following);
}

}  // namespace

int main(int argc, char** argv) {
  adit::bench::KeepOpenCvOnOneCore();
  std::string json = "{" + MeasureIn(Pages::kOrdinary) + ",\n";
  json += MeasureIn(Pages::kHuge) + "}\n";
  if (argc < 2) return 0;
  std::ofstream file(argv[1]);
  file << json;
  file.close();
  if (!file) {
    std::fprintf(stderr, "pair_table: %s: cannot be written\n", argv[1]);
    return 1;
  }
  return 0;
}
