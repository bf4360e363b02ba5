// Memory for images in huge pages, where the system has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>

namespace adit::linux {

struct FreeMemory {
  void operator()(std::uint8_t* memory) const { std::free(memory); }
};
using HugeMemory = std::unique_ptr<std::uint8_t, FreeMemory>;

/// At least `bytes`, zero, present in RAM, in pages of 2 MB if the kernel grants them: an image of 1400 x
/// 1024 lies in 350 ordinary pages, and to find each of them costs more than to read its first line.
HugeMemory AllocateHuge(std::size_t bytes);

}  // namespace adit::linux
