// Large records from one thread to another without copying them: a pool whose slots travel through a ring and
// back.
#pragma once

#include <array>
#include <memory>

#include "firmware/base/require.h"
#include "firmware/base/ring.h"

namespace adit::base {

/// Up to kLength records wait; a full conveyor drops its oldest, because the newest is worth more. The heap
/// is used in the constructor only. Draft and Commit belong to one producer thread, Pop and GiveBack to one
/// consumer thread, which holds at most kLength - 1 records at a time. `Atomic` as in DropOldestRing.
template <class T, std::size_t kLength, template <class> class Atomic = std::atomic>
class Conveyor {
 public:
  Conveyor() : slots_(std::make_unique<std::array<T, kSlots>>()) {
    for (T& slot : *slots_) free_.Push(&slot);
  }

  /// The record to fill next; the same one until Commit.
  T& Draft() {
    if (draft_ == nullptr) draft_ = free_.Pop().value_or(nullptr);
    ADIT_REQUIRE(draft_ != nullptr);  // there are more slots than the ring and the consumer can hold
    return *draft_;
  }

  /// Hands the draft over. If the ring was full, returns the oldest record, dropped; it is the next draft,
  /// its content unchanged until then.
  T* Commit() {
    T* const dropped = ready_.Push(&Draft()).value_or(nullptr);
    draft_ = dropped;
    return dropped;
  }

  /// The oldest record that waits, or nullptr.
  T* Pop() { return ready_.Pop().value_or(nullptr); }

  void GiveBack(T* record) { free_.Push(record); }

 private:
  static constexpr std::size_t kSlots = 2 * kLength;
  std::unique_ptr<std::array<T, kSlots>> slots_;
  T* draft_ = nullptr;
  DropOldestRing<T*, kLength, Atomic> ready_;  // producer -> consumer
  DropOldestRing<T*, kSlots, Atomic> free_;    // consumer -> producer
};

}  // namespace adit::base
