// Counts heap calls, so that a test can show that a path makes none.
#pragma once

#include <cstdint>

namespace adit::support {

/// Heap calls (malloc, calloc, realloc, aligned forms) of this thread since it started. Always 0 in sanitizer
/// builds, whose allocator is their own: check CountsAllocations() first.
std::uint64_t AllocationCount();

/// Whether AllocationCount works in this build.
bool CountsAllocations();

}  // namespace adit::support
