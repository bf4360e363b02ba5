#include "drivers/linux/huge_memory.h"

#include <algorithm>

#include <CppUTest/TestHarness.h>

TEST_GROUP(HugeMemory){};

TEST(HugeMemory, IsZeroAlignedAndWritableToItsEnd) {
  for (const std::size_t bytes :
       {std::size_t{1}, std::size_t{1400 * 1024}, std::size_t{2 << 20}, std::size_t{5'000'000}}) {
    const auto memory = adit::linux::AllocateHuge(bytes);
    LONGS_EQUAL(0, reinterpret_cast<std::uintptr_t>(memory.get()) % (2 << 20));
    CHECK(std::all_of(memory.get(), memory.get() + bytes, [](std::uint8_t byte) { return byte == 0; }));
    memory.get()[bytes - 1] = 1;
  }
}
