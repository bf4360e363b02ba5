// How long something took, counted without a lock: quantiles to 4.5 %, from 1 us to 10 s.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>

#include "firmware/base/time.h"

namespace adit::base {

/// A histogram of durations with 16 buckets per factor of two. All calls belong to any thread.
/// Durations below 1 us count as 1 us, above 17 s as 17 s, negative ones apart.
class DurationHistogram {
 public:
  void Add(DurationNs duration_ns) {
    // relaxed throughout: counts stand for themselves, nothing is published through them.
    if (duration_ns < 0) {
      negative_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    buckets_[BucketOf(duration_ns)].fetch_add(1, std::memory_order_relaxed);
    DurationNs max_ns = max_ns_.load(std::memory_order_relaxed);
    while (duration_ns > max_ns &&
           !max_ns_.compare_exchange_weak(max_ns, duration_ns, std::memory_order_relaxed)) {
    }
  }

  std::uint64_t Count() const {
    std::uint64_t count = 0;
    for (const auto& bucket : buckets_) count += bucket.load(std::memory_order_relaxed);
    return count;
  }

  /// Durations that came out negative: two clocks disagree.
  std::uint64_t Negative() const { return negative_.load(std::memory_order_relaxed); }

  DurationNs MaxNs() const { return max_ns_.load(std::memory_order_relaxed); }

  /// The upper edge of the bucket in which the fraction `quantile` (0 to 1) of all is reached, at most the
  /// longest of all; 0 when empty.
  DurationNs QuantileNs(double quantile) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(quantile * static_cast<double>(Count())));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      seen += buckets_[i].load(std::memory_order_relaxed);
      if (seen >= wanted && seen > 0) return std::min(UpperEdgeNs(i), MaxNs());
    }
    return 0;
  }

 private:
  static constexpr std::size_t kPerOctave = 16;
  static constexpr std::size_t kOctaves = 24;  // 1024 ns << 24 is 17 s
  static constexpr std::size_t kBuckets = kPerOctave * kOctaves;
  static constexpr int kShift = 10;  // the first octave starts at 1024 ns

  /// The four bits after the leading one choose the bucket within the octave.
  static std::size_t BucketOf(DurationNs duration_ns) {
    const auto value = static_cast<std::uint64_t>(duration_ns);
    if (value < (1ULL << kShift)) return 0;
    const int octave = static_cast<int>(std::bit_width(value)) - 1 - kShift;
    const std::size_t within = (value >> (octave + kShift - 4)) & 15;
    const std::size_t bucket = static_cast<std::size_t>(octave) * kPerOctave + within;
    return bucket < kBuckets ? bucket : kBuckets - 1;
  }
  static DurationNs UpperEdgeNs(std::size_t bucket) {
    const auto octave = static_cast<int>(bucket / kPerOctave);
    return static_cast<DurationNs>((17 + bucket % kPerOctave) << (octave + kShift - 4));
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> negative_{0};
  std::atomic<DurationNs> max_ns_{0};
};

}  // namespace adit::base
