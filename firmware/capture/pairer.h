// Which two frames belong to the same trigger.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "firmware/base/fixed_vector.h"
#include "firmware/base/image.h"

namespace adit::capture {

/// When two frames are of one trigger, and how long one waits.
struct PairerOptions {
  base::DurationNs period_ns = base::kNsPerS / 60;  ///< between triggers
  /// Of the period: how far apart mid-exposures of one trigger may be. Below a half, or a frame could match
  /// two; a quarter leaves room for clocks that are mapped with milliseconds of jitter.
  double tolerance = 0.25;
  /// How long a frame waits for a partner that may still come: packets resent at 1 % loss take up to 62 ms.
  base::DurationNs patience_ns = 80 * base::kNsPerMs;
};

/// What became of the frames.
struct PairerCounts {
  std::uint64_t paired = 0;
  std::array<std::uint64_t, 2> unpaired{};  ///< left, right
  /// Frames whose exposures lie farther apart than their arrivals can explain: one camera's clock is wrong.
  std::uint64_t out_of_step = 0;
  /// A camera's time went backwards: its clock was set, or it restarted.
  std::array<std::uint64_t, 2> backwards{};
};

/// A pair, or one frame that has no partner: the caller owns what stands here again.
template <class T>
struct PairerEvent {
  std::optional<T> left, right;
  bool Paired() const { return left.has_value() && right.has_value(); }
};

/// Pairs the frames of two cameras by mid-exposure time. T is a handle (pointer or index).
///
/// Times decide alone: frame counts wrap, skip, and restart with the camera, each on its own. Frames of one
/// side must come in the order of their exposures. A lost frame costs its pair and no more: its partner
/// leaves as soon as the other side delivers something younger. A camera that falls silent costs the other's
/// frames, each after `patience_ns`; nothing piles up. If one camera's clock is set, its waiting frames
/// leave and no pair is made until both clocks agree again: times that disagree are never explained away,
/// since a pair of two different triggers is a wrong position.
///
///   pairer.Add(stamp, frame);
///   while (const auto event = pairer.Next(now_ns)) { ... }
///
/// One thread; no allocation. A frame whose status is not kOk is paired like any other.
template <class T>
class Pairer {
 public:
  static constexpr std::size_t kWaitingMax = 16;  ///< a side: a quarter of a second at 60 Hz

  explicit Pairer(const PairerOptions& options)
      : patience_ns_(options.patience_ns),
        tolerance_ns_(
            static_cast<base::DurationNs>(static_cast<double>(options.period_ns) * options.tolerance)) {}

  /// Takes a frame. Next() must have run dry since the last one.
  void Add(const base::FrameStamp& stamp, T frame) {
    const std::size_t side = stamp.side == base::Side::kLeft ? 0 : 1;
    Queue& queue = queues_[side];
    if (stamp.mid_exposure_ns <= queue.newest_ns) {
      // What waits is dated by a clock that no longer holds.
      ++counts_.backwards[side];
      queue.stale = queue.size;
    }
    queue.newest_ns = stamp.mid_exposure_ns;
    ADIT_REQUIRE(queue.size < kWaitingMax);
    queue.Push({stamp.mid_exposure_ns, stamp.last_packet_ns, frame});
  }

  /// The next pair or partnerless frame, oldest first; none when everything left may still find its partner.
  /// `now_ns` is the box clock. In a replay give kNever: nothing is late there.
  std::optional<PairerEvent<T>> Next(base::TimeNs now_ns) {
    for (const std::size_t side : {0UL, 1UL}) {
      if (queues_[side].stale > 0) return Release(side);
    }
    if (queues_[0].size > 0 && queues_[1].size > 0) return Match();
    for (const std::size_t side : {0UL, 1UL}) {
      const Queue& queue = queues_[side];
      if (queue.size == kWaitingMax || (queue.size > 0 && IsLate(queue.Front(), now_ns)))
        return Release(side);
    }
    return std::nullopt;
  }

  /// At the end, or when a camera is given up: one waiting frame at a time.
  std::optional<PairerEvent<T>> Flush() {
    for (const std::size_t side : {0UL, 1UL}) {
      if (queues_[side].size > 0) return Release(side);
    }
    return std::nullopt;
  }

  const PairerCounts& Counts() const { return counts_; }

 private:
  struct Waiting {
    base::TimeNs mid_exposure_ns = base::kNever;
    base::TimeNs last_packet_ns = base::kNever;
    T frame{};
  };

  struct Queue {
    std::array<Waiting, kWaitingMax> items{};
    std::size_t first = 0, size = 0;
    std::size_t stale = 0;  ///< this many of the oldest are to leave
    base::TimeNs newest_ns = base::kNever;
    const Waiting& Front() const { return items[first]; }
    void Push(const Waiting& item) { items[(first + size++) % kWaitingMax] = item; }
    Waiting Pop() {
      const Waiting item = items[first];
      first = (first + 1) % kWaitingMax;
      --size;
      stale -= std::min<std::size_t>(stale, 1);
      return item;
    }
  };

  std::optional<PairerEvent<T>> Match() {
    const Waiting& left = queues_[0].Front();
    const Waiting& right = queues_[1].Front();
    // Unsigned: the times may be any, and their difference must not overflow.
    const bool left_is_older = left.mid_exposure_ns < right.mid_exposure_ns;
    const auto apart_ns = Apart(left.mid_exposure_ns, right.mid_exposure_ns);
    if (apart_ns <= static_cast<std::uint64_t>(tolerance_ns_)) {
      ++counts_.paired;
      return PairerEvent<T>{queues_[0].Pop().frame, queues_[1].Pop().frame};
    }
    if (left.last_packet_ns != base::kNever && right.last_packet_ns != base::kNever) {
      // Frames are late by resending, never early: exposures cannot lie farther apart than arrivals do by
      // more than that.
      const std::uint64_t arrived_apart_ns = Apart(left.last_packet_ns, right.last_packet_ns);
      if (apart_ns > arrived_apart_ns &&
          apart_ns - arrived_apart_ns > static_cast<std::uint64_t>(patience_ns_))
        ++counts_.out_of_step;
    }
    return Release(left_is_older ? 0 : 1);
  }

  static std::uint64_t Apart(base::TimeNs a_ns, base::TimeNs b_ns) {
    const auto low = static_cast<std::uint64_t>(std::min(a_ns, b_ns));
    return static_cast<std::uint64_t>(std::max(a_ns, b_ns)) - low;
  }

  std::optional<PairerEvent<T>> Release(std::size_t side) {
    ++counts_.unpaired[side];
    const T frame = queues_[side].Pop().frame;
    PairerEvent<T> event;
    (side == 0 ? event.left : event.right) = frame;
    return event;
  }

  bool IsLate(const Waiting& waiting, base::TimeNs now_ns) const {
    const base::TimeNs since_ns =
        waiting.last_packet_ns != base::kNever ? waiting.last_packet_ns : waiting.mid_exposure_ns;
    return now_ns != base::kNever && since_ns < now_ns &&
           Apart(now_ns, since_ns) > static_cast<std::uint64_t>(patience_ns_);
  }

  base::DurationNs patience_ns_, tolerance_ns_;
  std::array<Queue, 2> queues_{};
  PairerCounts counts_;
};

}  // namespace adit::capture
