// A Modbus request -> its reply: a pure function of the bytes and of one register image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/publish/register_map.h"

namespace adit::publish {

/// A unit id and the longest PDU of Modbus (Modbus Application Protocol V1.1b3, section 4.1).
inline constexpr std::size_t kMaxModbusMessage = 1 + 253;

/// Answers on behalf of one box. Any thread; no heap, no lock.
class ModbusResponder {
 public:
  /// `map` must outlive this. `unit` 1 to 247; 0 and 255 are answered too, as boxes behind no gateway do.
  ModbusResponder(const RegisterMap& map, std::uint8_t unit) : map_(map), unit_(unit) {}

  /// `request` is unit id and PDU; so is what it writes to `reply`, whose length it returns. Serves FC 02,
  /// 03, 04 (03 and 04 read the same registers) and 43/14. One answer is one epoch. Exceptions in the
  /// spec's order: 0x0B another unit, 01 function (writes are off), 03 length or count, 02 address. Silence
  /// (0) for less than a function code, or if `reply` is shorter than kMaxModbusMessage.
  std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply,
                     base::TimeNs now_ns) const;

 private:
  const RegisterMap& map_;
  std::uint8_t unit_;
};

}  // namespace adit::publish
