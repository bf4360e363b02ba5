#include "tests/support/allocation_guard.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

namespace adit::support {
std::uint64_t AllocationCount() { return 0; }
ProcessCounts CountsOfAllThreads() { return {}; }
bool CountsAllocations() { return false; }
}  // namespace adit::support

#else

namespace {
thread_local std::uint64_t allocation_count = 0;
std::atomic<std::uint64_t> allocations_of_all{0}, locks_of_all{0};

using Lock = int (*)(pthread_mutex_t*);

/// glibc keeps no second name of it to link to.
Lock RealLock() {
  static std::atomic<Lock> real{nullptr};
  Lock lock = real.load(std::memory_order_relaxed);  // relaxed: every thread would find the same
  if (lock == nullptr) {
    lock = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
    real.store(lock, std::memory_order_relaxed);
  }
  return lock;
}

void CountAllocation() {
  ++allocation_count;
  allocations_of_all.fetch_add(1, std::memory_order_relaxed);  // relaxed: counts stand for themselves
}
}  // namespace

// glibc's own entry points behind the public names.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  locks_of_all.fetch_add(1, std::memory_order_relaxed);
  return RealLock()(mutex);
}
void* malloc(std::size_t size) {
  CountAllocation();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  CountAllocation();
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  CountAllocation();
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  CountAllocation();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  CountAllocation();
  return __libc_memalign(alignment, size);
}
}

namespace adit::support {
std::uint64_t AllocationCount() { return allocation_count; }
ProcessCounts CountsOfAllThreads() {
  return {allocations_of_all.load(std::memory_order_relaxed), locks_of_all.load(std::memory_order_relaxed)};
}
bool CountsAllocations() { return true; }
}  // namespace adit::support

#endif
