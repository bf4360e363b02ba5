// Hand-over between two threads: lock-free, fixed size, one producer, one consumer. A full ring gives its
// oldest item back to the producer, who counts it: the newest image is worth more than the oldest.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace adit::base {

/// A ring of up to N small trivially copyable items (pointers, indices). Push belongs to one thread, Pop to
/// one other. Positions only grow; slot = position mod N. `Atomic` is std::atomic; the tests put a model of
/// it here that tries every order of steps and every value that a memory order lets a load return.
///
/// Both ends may take the oldest item (the producer when full, the consumer always), so `read_` moves by
/// compare-exchange: whoever moves it from p to p+1 owns what stood in slot p, and exactly one can. The
/// consumer reads the slot before its exchange; if the producer took that item meanwhile, the exchange fails
/// and the value is discarded. The slots are atomics, so that this early read is no data race. 64-bit
/// positions do not come back within a box's life, so a stale position never matches by accident.
template <class T, std::size_t N, template <class> class Atomic = std::atomic>
class DropOldestRing {
  static_assert(std::is_trivially_copyable_v<T> && Atomic<T>::is_always_lock_free);
  static_assert(N >= 2 && (N & (N - 1)) == 0, "a power of two");

 public:
  /// Adds `item`. Returns the oldest item if it had to make room: the producer owns that one again.
  std::optional<T> Push(T item) {
    // relaxed: only this thread writes write_.
    const std::uint64_t write = write_.load(std::memory_order_relaxed);
    // acquire: pairs with the consumer's exchange, so that its read of the slot we are about to reuse is
    // over.
    std::uint64_t read = read_.load(std::memory_order_acquire);
    std::optional<T> dropped;
    if (write - read == N) {
      // relaxed: this thread wrote the slot itself.
      const T oldest = slots_[read % N].load(std::memory_order_relaxed);
      // release: a consumer that sees the position moved sees the write_ ahead of it too; with an older one
      // it would run past the end. acquire: on failure the consumer has taken the item, and its read of the
      // slot is over before we reuse it.
      if (read_.compare_exchange_strong(read, read + 1, std::memory_order_acq_rel,
                                        std::memory_order_acquire)) {
        dropped = oldest;
      }
    }
    slots_[write % N].store(item, std::memory_order_relaxed);
    // release: publishes the slot, and what the item points to, before the position.
    write_.store(write + 1, std::memory_order_release);
    return dropped;
  }

  /// Takes the oldest item, if there is one.
  std::optional<T> Pop() {
    // acquire: pairs with the producer's exchange, so that a position it moved is seen with what follows.
    std::uint64_t read = read_.load(std::memory_order_acquire);
    for (;;) {
      // acquire: pairs with the release in Push; slot and pointee are visible.
      if (read == write_.load(std::memory_order_acquire)) return std::nullopt;
      const T item = slots_[read % N].load(std::memory_order_relaxed);
      // release: the read of the slot above is over before the producer, which acquires the new position,
      // reuses the slot. acquire: on failure the producer moved the position; see the write_ ahead of it.
      if (read_.compare_exchange_weak(read, read + 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
        return item;
      }
    }
  }

  /// Items waiting; a snapshot, exact only when both sides rest.
  std::size_t SizeApprox() const {
    // acquire on read_ first: write_ is then at least as new, the difference never negative. Pushes between
    // the two loads can make it larger than the ring.
    const std::uint64_t read = read_.load(std::memory_order_acquire);
    return static_cast<std::size_t>(
        std::min<std::uint64_t>(write_.load(std::memory_order_acquire) - read, N));
  }

 private:
  static constexpr std::size_t kCacheLineBytes = 64;  // x86-64 and Cortex-A
  alignas(kCacheLineBytes) Atomic<std::uint64_t> write_{0};
  alignas(kCacheLineBytes) Atomic<std::uint64_t> read_{0};
  alignas(kCacheLineBytes) std::array<Atomic<T>, N> slots_{};
};

}  // namespace adit::base
