#include "tests/support/allocation_guard.h"

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

namespace adit::support {
std::uint64_t AllocationCount() { return 0; }
bool CountsAllocations() { return false; }
}  // namespace adit::support

#else

namespace {
thread_local std::uint64_t allocation_count = 0;
}

// glibc's own entry points behind the public names.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocation_count;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocation_count;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  ++allocation_count;
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++allocation_count;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocation_count;
  return __libc_memalign(alignment, size);
}
}

namespace adit::support {
std::uint64_t AllocationCount() { return allocation_count; }
bool CountsAllocations() { return true; }
}  // namespace adit::support

#endif
