// How the cost of a pair grows with the size of its images, with the blobs in them, and with the targets:
// searched all over, one core, images from memory, each beside reading the same images. Usage: cost_curves
// [curves.json]; plot.py draws them.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "firmware/base/require.h"
#include "firmware/pipeline/pipeline.h"
#include "tests/bench/bench_frames.h"
#include "tests/bench/read_bound.h"
#include "tests/bench/stopwatch.h"

namespace {

using adit::base::Side;
using adit::bench::Crowd;
using adit::bench::ImagePair;
using adit::bench::Median;
using adit::bench::Size;
using adit::bench::TimeUs;

constexpr std::size_t kImageBytes = 128U << 20;  // of all pairs of a point: more than any cache holds
constexpr int kPasses = 4;                       // and one before them that is not counted
constexpr adit::base::DurationNs kPeriodNs = adit::base::kNsPerS / 60;

struct Point {
  double x = 0;
  double pair_us = 0, read_us = 0;
  double located = 0;  ///< share of the targets
};

Point Measure(const Crowd& crowd, double x) {
  const auto stage = MakeStage(crowd);
  auto pipeline =
      *adit::pipeline::Pipeline::Make(stage.rig, stage.models, {.detector = {}, .windows = false});
  const int count = static_cast<int>(std::max<std::size_t>(8, kImageBytes / (2 * crowd.size.Bytes())));
  const std::vector<ImagePair> pairs = RenderCrowd(crowd, count, 1);
  auto left = std::make_unique<adit::detect::BlobSet>(), right = std::make_unique<adit::detect::BlobSet>();
  auto result = std::make_unique<adit::pipeline::PairResult>();
  std::vector<double> pair_us, read_us;
  std::size_t sink = 0;
  double located = 0;
  for (int i = 0; i < count * (kPasses + 1); ++i) {
    const ImagePair& read = pairs[static_cast<std::size_t>(i % count)];
    const ImagePair& pair = pairs[static_cast<std::size_t>((i + count / 2) % count)];
    read_us.push_back(TimeUs([&] {
      sink += adit::bench::ReadAll(read.left.Pixels()) + adit::bench::ReadAll(read.right.Pixels());
    }));
    pair_us.push_back(TimeUs([&] {
      pipeline.Detect(pair.Frame(Side::kLeft, i * kPeriodNs), *left);
      pipeline.Detect(pair.Frame(Side::kRight, i * kPeriodNs), *right);
      pipeline.Locate(*left, *right, *result);
    }));
    if (i == count - 1) pair_us.clear(), read_us.clear();
    for (const auto& target : result->points.targets)
      located += i >= count && target.status == adit::stereo::FixStatus::kTracked ? 1 : 0;
  }
  ADIT_REQUIRE(sink > 0);
  return {x, Median(pair_us), Median(read_us),
          located / static_cast<double>(count * kPasses) / static_cast<double>(crowd.targets)};
}

std::string Json(const char* name, const std::vector<Point>& points) {
  std::ostringstream out;
  out << "\"" << name << "\": [";
  for (const Point& point : points) {
    out << (&point == points.data() ? "\n" : ",\n") << "  {\"x\": " << point.x
        << ", \"pair_us\": " << point.pair_us << ", \"read_us\": " << point.read_us
        << ", \"located\": " << point.located << "}";
    std::printf("%-10s %8.2f: pair %7.1f us, read %7.1f us, %5.1f %% of the targets located\n", name, point.x,
                point.pair_us, point.read_us, 100 * point.located);
  }
  std::fflush(stdout);
  out << "]";
  return out.str();
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Point> megapixels, blobs, targets;
  for (const Size& size :
       {Size{640, 512}, Size{1400, 1024}, Size{1936, 1216}, Size{2448, 2048}, Size{4096, 3000}})
    megapixels.push_back(Measure({size, 2, 12}, 1e-6 * static_cast<double>(size.Bytes())));
  std::string json = "{" + Json("megapixels", megapixels) + ",\n";
  for (const int spots : {0, 22, 52, 112, 192, 292, 392}) blobs.push_back(Measure({{}, 2, spots}, spots + 8));
  json += Json("blobs", blobs) + ",\n";
  for (const std::size_t count : {1U, 2U, 4U, 8U, 16U, 32U})
    targets.push_back(Measure({{}, count, 12}, static_cast<double>(count)));
  json += Json("targets", targets) + "}\n";
  if (argc < 2) return 0;
  std::ofstream file(argv[1]);
  file << json;
  file.close();
  if (!file) {
    std::fprintf(stderr, "cost_curves: %s: cannot be written\n", argv[1]);
    return 1;
  }
  return 0;
}
