// CRC-16/CCITT-FALSE: the checksum of AUTOSAR E2E profile 5 and of the live block of the Modbus map.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace adit::publish {

/// Before the first byte (AUTOSAR CRC library, 7.2.2).
inline constexpr std::uint16_t kCrc16Start = 0xFFFF;

namespace detail {
consteval std::array<std::uint16_t, 256> MakeCrc16Table() {
  constexpr unsigned kPolynomial = 0x1021;
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? (crc << 1) ^ kPolynomial : crc << 1;
    table[byte] = static_cast<std::uint16_t>(crc & 0xFFFFU);
  }
  return table;
}
inline constexpr std::array<std::uint16_t, 256> kCrc16Table = MakeCrc16Table();
}  // namespace detail

/// Polynomial 0x1021, start 0xFFFF, not reflected, nothing xored out; "123456789" gives 0x29B1. Hand the
/// last result in as `crc` to go on.
constexpr std::uint16_t Crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc = kCrc16Start) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>((crc << 8) ^ detail::kCrc16Table[(crc >> 8) ^ byte]);
  }
  return crc;
}

}  // namespace adit::publish
