// The latest value of something, readable by any number of threads without ever blocking its one writer.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace adit::base {

/// A seqlock over words. Store belongs to one thread; Load to any. A reader that meets a write in progress
/// tries again; the writer never waits. The payload is copied through relaxed atomic words, so that a torn
/// read is a retry and not undefined behaviour (Boehm, "Can seqlocks get along with programming language
/// memory models?", MSPC 2012, section 4).
///
/// `Atomic` is std::atomic; the tests put a model of it here.
template <class T, template <class> class Atomic = std::atomic>
class Latest {
  static_assert(std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>);

 public:
  void Store(const T& value) {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), static_cast<const void*>(&value), sizeof(T));
    // relaxed: only this thread writes sequence_.
    const std::uint64_t sequence = sequence_.load(std::memory_order_relaxed);
    sequence_.store(sequence + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kWords; ++i) {
      // release: a reader that sees this word also sees the odd sequence stored before it, and retries.
      words_[i].store(words[i], std::memory_order_release);
    }
    // release: whoever sees the even sequence sees all the words.
    sequence_.store(sequence + 2, std::memory_order_release);
  }

  /// The newest complete value, or a default T before the first Store; `stores` counts how often it was
  /// stored.
  T Load(std::uint64_t* stores = nullptr) const {
    std::array<std::uint64_t, kWords> words{};
    for (;;) {
      // acquire: pairs with the final release in Store.
      const std::uint64_t before = sequence_.load(std::memory_order_acquire);
      if (before % 2 == 1) continue;
      for (std::size_t i = 0; i < kWords; ++i) {
        // acquire: keeps the check below after these reads, and pairs with the words' releases.
        words[i] = words_[i].load(std::memory_order_acquire);
      }
      // relaxed: ordered by the acquire reads above.
      if (sequence_.load(std::memory_order_relaxed) != before) continue;
      if (stores != nullptr) *stores = before / 2;
      if (before == 0) return T{};
      T value;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
      return value;
    }
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  Atomic<std::uint64_t> sequence_{0};
  std::array<Atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace adit::base
