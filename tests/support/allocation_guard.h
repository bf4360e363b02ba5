// Counts heap calls and locks, so that a test can show that a path makes none.
#pragma once

#include <cstdint>

namespace adit::support {

/// Heap calls (malloc, calloc, realloc, aligned forms) of this thread since it started. Always 0 in sanitizer
/// builds, whose allocator is their own: check CountsAllocations() first.
std::uint64_t AllocationCount();

/// Heap calls and mutex locks (pthread_mutex_lock, so std::mutex too) of all threads since the start.
struct ProcessCounts {
  std::uint64_t allocations = 0, locks = 0;
};
ProcessCounts CountsOfAllThreads();

/// Whether these counts work in this build.
bool CountsAllocations();

}  // namespace adit::support
