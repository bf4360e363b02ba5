// A classic CAN frame, as encoders make it and field buses carry it.
#pragma once

#include <array>
#include <cstdint>

namespace adit::base {

struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bit, or 29 bit if extended
  bool extended = false;
  std::uint8_t length = 8;
  std::array<std::uint8_t, 8> data{};

  bool operator==(const CanFrame&) const = default;
};

}  // namespace adit::base
