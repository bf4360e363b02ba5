// The one table of everything on the wire. Encoders, receiver, DBC, register map and documents come from
// it, so that they cannot disagree. Bump the version of the layout, and the changelog, with every change
// here.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/publish/register_map.h"

namespace adit::publish {

inline constexpr double kStepM = 1e-4;  ///< of positions on the wire: 0.1 mm

enum class WireType : std::uint8_t { kU16, kI16, kU32, kI32, kF32, kF64 };

/// Registers that a type takes.
constexpr unsigned WordsOf(WireType type) {
  switch (type) {
    case WireType::kU16:
    case WireType::kI16:
      return 1;
    case WireType::kU32:
    case WireType::kI32:
    case WireType::kF32:
      return 2;
    case WireType::kF64:
      break;
  }
  return 4;
}

constexpr bool IsSigned(WireType type) { return type == WireType::kI16 || type == WireType::kI32; }

/// Not available, as it stands on the wire.
inline constexpr std::int64_t kNoI32 = INT32_MIN;
inline constexpr std::int64_t kNoI16 = INT16_MIN;
inline constexpr std::int64_t kNoU16 = UINT16_MAX;
inline constexpr std::nullopt_t kAlways = std::nullopt;  ///< never "not available"

/// Where a signal stands in the value (bytes 0-3) of a CAN frame, little-endian.
struct CanPlace {
  std::uint8_t slot = 0;
  std::uint8_t start_bit = 0;
  std::uint8_t bits = 0;  ///< 0: not on CAN; a number that does not fit is clamped
};

/// One quantity. `raw` gives it in steps of `scale` `unit`; floats as their bits.
struct SignalRow {
  const char* name;
  const char* unit;
  double scale;
  WireType type;
  std::optional<std::int64_t> not_available;
  CanPlace can;
  std::optional<std::uint16_t> address;  ///< of the first register; none: not in the map
  const char* meaning;
  std::int64_t (*raw)(const BoxRecord& record);
};
std::span<const SignalRow> Signals();

/// One message of the common shape. INFO is multiplexed and differs in byte 4.
struct CanSlot {
  std::uint8_t slot;
  const char* name;
  std::uint16_t id_base;     ///< plus node, plus node_offset
  std::uint8_t node_offset;  ///< block B speaks as the next node
};
std::span<const CanSlot> CanSlots();
const CanSlot* FindCanSlot(std::uint8_t slot);

inline constexpr std::uint8_t kStatusSlot = 3;
inline constexpr std::uint8_t kInfoSlot = 8;
/// Above it, 0x680 + node would run into ids that CiA 301 keeps for itself.
inline constexpr std::uint8_t kInfoNodeMax = 0x5F;

/// One number of INFO: byte 0 index, bytes 1-4 the number.
struct InfoRow {
  const char* name;
  const char* unit;
  WireType type;  ///< kU32 or kI32
  const char* meaning;
  std::int64_t (*raw)(const BoxRecord& record);
};
std::span<const InfoRow> InfoRows();

/// One field of a target's struct, at kTargetsFirst + kTargetLength * i + offset.
struct TargetRow {
  std::uint8_t offset;
  const char* name;
  const char* unit;
  double scale;
  WireType type;
  std::optional<std::int64_t> not_available;
  const char* meaning;
  std::int64_t (*raw)(const TargetRecord& record, base::TimeNs now_ns);
};
std::span<const TargetRow> TargetRows();

/// 32 ASCII characters in 16 registers, zero padded.
struct LabelRow {
  std::uint16_t address;
  const char* name;
  Label BoxIdentity::*text;
};
std::span<const LabelRow> LabelRows();

/// FC02, in the order of their addresses from 0.
struct BitRow {
  const char* name;
  const char* meaning;
  bool (*on)(const BoxRecord& record);
};
std::span<const BitRow> BitRows();

/// Fault bits, in the order of their bits from 0.
std::span<const char* const> FaultNames();

/// A stretch of registers that exist; reserved ones in it read 0.
struct RegisterArea {
  std::uint16_t first;
  std::uint16_t count;
  const char* content;
};
std::span<const RegisterArea> RegisterAreas();

/// Where the CRC of the live block stands, and the id that ends what it covers.
inline constexpr std::uint16_t kLiveCrcAddress = kLiveFirst + kLiveLength - 1;
inline constexpr std::uint16_t kLiveDataId = 0xA0FF;

}  // namespace adit::publish
