#include "firmware/base/histogram.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include <CppUTest/TestHarness.h>

using adit::base::DurationHistogram;
using adit::base::DurationNs;

TEST_GROUP(DurationHistogram){};

TEST(DurationHistogram, EmptyHasNoQuantiles) {
  DurationHistogram histogram;
  LONGS_EQUAL(0, histogram.QuantileNs(0.5));
  LONGS_EQUAL(0, histogram.Count());
}

TEST(DurationHistogram, QuantilesAreWithinABucketAboveTheSortedTruth_Seed7) {
  DurationHistogram histogram;
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> durations(std::log(2e5), 1.5);
  std::vector<DurationNs> sorted;
  for (int i = 0; i < 20'000; ++i) {
    sorted.push_back(static_cast<DurationNs>(2000 + durations(random)));
    histogram.Add(sorted.back());
  }
  std::sort(sorted.begin(), sorted.end());
  for (const double quantile : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(quantile * 20'000)) - 1;
    const double truth = static_cast<double>(sorted[rank]);
    const double told = static_cast<double>(histogram.QuantileNs(quantile));
    CHECK(told >= truth);
    CHECK(told <= truth * (1 + 1.0 / 16) + 1);
  }
  CHECK_EQUAL(sorted.back(), histogram.MaxNs());
}

TEST(DurationHistogram, ExtremesLandInTheOuterBucketsAndNegativesApart) {
  DurationHistogram histogram;
  histogram.Add(0);
  histogram.Add(INT64_MAX);
  histogram.Add(-1);
  LONGS_EQUAL(2, histogram.Count());
  LONGS_EQUAL(1, histogram.Negative());
  CHECK(histogram.QuantileNs(0.5) <= 1088);
  CHECK(histogram.QuantileNs(1.0) > 16 * adit::base::kNsPerS);
}

TEST(DurationHistogram, NoQuantileIsLongerThanTheLongest) {
  DurationHistogram histogram;
  for (int i = 0; i < 10; ++i) histogram.Add(1'000'000);
  CHECK_EQUAL(1'000'000, histogram.QuantileNs(0.5));
  CHECK_EQUAL(1'000'000, histogram.QuantileNs(1.0));
}

TEST(DurationHistogram, ThreeWritersAndAReaderLoseNothing) {
  constexpr int kEach = 50'000, kWriters = 3;
  DurationHistogram histogram;
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&histogram, w] {
      for (int i = 1; i <= kEach; ++i) histogram.Add(2000 + kWriters * i + w);
    });
  }
  bool bounded = true;
  std::uint64_t seen = 0;
  while (seen < kEach * kWriters) {
    const std::uint64_t now = histogram.Count();
    bounded = bounded && now >= seen && histogram.QuantileNs(0.5) <= 2000 + kWriters * (kEach + 1);
    seen = now;
  }
  for (std::thread& writer : writers) writer.join();
  CHECK(bounded);
  LONGS_EQUAL(kEach * kWriters, histogram.Count());
  CHECK_EQUAL(2000 + kWriters * kEach + kWriters - 1, histogram.MaxNs());
}
