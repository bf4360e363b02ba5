#include "drivers/linux/huge_memory.h"

#include <sys/mman.h>

#include <cstring>

#include "firmware/base/require.h"

namespace adit::linux {

HugeMemory AllocateHuge(std::size_t bytes) {
  constexpr std::size_t kPageBytes = 2U << 20;
  const std::size_t rounded = (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
  HugeMemory memory(static_cast<std::uint8_t*>(std::aligned_alloc(kPageBytes, rounded)));
  ADIT_REQUIRE(memory != nullptr);
  // Advice: where it is not taken the pages are ordinary ones, and all works.
  (void)madvise(memory.get(), rounded, MADV_HUGEPAGE);
  std::memset(memory.get(), 0, rounded);
  return memory;
}

}  // namespace adit::linux
