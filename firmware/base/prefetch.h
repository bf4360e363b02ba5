// Tells the memory what will be read soon.
#pragma once

#include <cstddef>
#include <cstdint>

namespace adit::base {

/// Fetches `count` bytes from `at` on into the cache without waiting for them. Pays where the next reads
/// jump; along rows the processor does it by itself.
inline void Prefetch(const std::uint8_t* at, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kLineBytes = 64;
  // To GCC a function that only prefetches has no effect, and it drops the calls: the empty statement has
  // one.
  asm volatile("");
  for (std::ptrdiff_t i = 0; i < count; i += kLineBytes) __builtin_prefetch(at + i);
  __builtin_prefetch(at + count - 1);
}

}  // namespace adit::base
