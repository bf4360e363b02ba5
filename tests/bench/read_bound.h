// The least that looking at an image can cost: reading it.
#pragma once

#include <cstdint>
#include <span>

namespace adit::bench {

/// The brightest pixel, by the widest instructions of this machine.
std::uint8_t ReadAll(std::span<const std::uint8_t> pixels);

}  // namespace adit::bench
