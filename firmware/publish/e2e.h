// AUTOSAR E2E profile 5 on an 8-byte frame, offset 40 bit: the CRC stands in bytes 5-6, the counter in byte
// 7.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/publish/crc16.h"

namespace adit::publish {

using Payload = std::array<std::uint8_t, 8>;

inline constexpr std::size_t kE2eCrcByte = 5;      ///< 40 bit / 8
inline constexpr std::size_t kE2eCounterByte = 7;  ///< follows the CRC in profile 5

/// The id that goes into the CRC but not over the wire: a frame of another box or slot never passes.
constexpr std::uint16_t DataId(std::uint8_t address, std::uint8_t slot) {
  return static_cast<std::uint16_t>(0xA000U | (static_cast<unsigned>(address) << 4) | (slot & 0x0FU));
}

/// Over bytes 0-4, 7, then the data id, low byte first (AUTOSAR PRS_E2EProtocol, profile 5).
constexpr std::uint16_t E2eCrc(const Payload& payload, std::uint16_t data_id) {
  const std::array<std::uint8_t, 8> covered{payload[0],
                                            payload[1],
                                            payload[2],
                                            payload[3],
                                            payload[4],
                                            payload[kE2eCounterByte],
                                            static_cast<std::uint8_t>(data_id & 0xFFU),
                                            static_cast<std::uint8_t>(data_id >> 8)};
  return Crc16(covered);
}

/// Writes counter and CRC (little-endian) into `payload`.
constexpr void Protect(Payload& payload, std::uint16_t data_id, std::uint8_t counter) {
  payload[kE2eCounterByte] = counter;
  const std::uint16_t crc = E2eCrc(payload, data_id);
  payload[kE2eCrcByte] = static_cast<std::uint8_t>(crc & 0xFFU);
  payload[kE2eCrcByte + 1] = static_cast<std::uint8_t>(crc >> 8);
}

/// Whether the CRC holds.
constexpr bool Check(const Payload& payload, std::uint16_t data_id) {
  const unsigned stored = payload[kE2eCrcByte] | (static_cast<unsigned>(payload[kE2eCrcByte + 1]) << 8);
  return stored == E2eCrc(payload, data_id);
}

}  // namespace adit::publish
