// A camera's frame ids and time stamps, made ones that the box can use.
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/base/time.h"

namespace adit::aravis {

/// GigE Vision frame ids -> a count that only grows. Ids of 16 bits go from 65535 to 1 (0 is never used); ids
/// of 64 bits do not wrap. After Restart the count goes on from where it was.
class FrameCounter {
 public:
  /// Of the next frame. `missed` gets the number of ids skipped since the last one.
  std::uint64_t Count(std::uint64_t id, std::uint64_t& missed) {
    missed = 0;
    if (!started_) {
      started_ = true;
      count_ += count_ == 0 ? 0 : 1;
    } else {
      const std::uint64_t step = Step(last_id_, id);
      missed = step > 0 ? step - 1 : 0;
      count_ += step;
    }
    last_id_ = id;
    return count_;
  }
  /// The camera begins its ids anew.
  void Restart() { started_ = false; }

 private:
  static constexpr std::uint64_t kIds16 = 65535;

  /// How many frames lie between two ids. An id that repeats or goes backwards without a wrap counts as the
  /// next frame: the camera has restarted its count.
  static std::uint64_t Step(std::uint64_t from, std::uint64_t to) {
    if (to > from) return to - from;
    const bool wraps = from <= kIds16 && from - to > kIds16 / 2;
    return wraps ? to + kIds16 - from : 1;
  }

  bool started_ = false;
  std::uint64_t last_id_ = 0;
  std::uint64_t count_ = 0;
};

/// The time of a camera that runs on its own clock, on the box clock: the camera's time plus the smallest
/// difference between arrival and camera time of late, since delays only add. Late by the shortest transfer;
/// follows a drift of up to 100 ppm by letting the minimum rise that fast.
class ClockMap {
 public:
  /// The box time of `camera_ns`, of a frame whose first packet came at `arrival_ns`.
  base::TimeNs ToBox(base::TimeNs camera_ns, base::TimeNs arrival_ns) {
    const base::DurationNs difference_ns = arrival_ns - camera_ns;
    if (offset_ns_ == base::kNever) {
      offset_ns_ = difference_ns;
    } else {
      const base::DurationNs elapsed_ns = std::max<base::DurationNs>(0, arrival_ns - last_arrival_ns_);
      offset_ns_ = std::min(difference_ns, offset_ns_ + elapsed_ns / kDriftDivisor);
    }
    last_arrival_ns_ = arrival_ns;
    return camera_ns + offset_ns_;
  }
  void Restart() { offset_ns_ = base::kNever; }

 private:
  static constexpr base::DurationNs kDriftDivisor = 10'000;  // 100 ppm: twice what two bad crystals differ by
  base::DurationNs offset_ns_ = base::kNever;
  base::TimeNs last_arrival_ns_ = 0;
};

}  // namespace adit::aravis
