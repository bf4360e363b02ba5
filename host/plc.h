// A PLC's view of the box: a Modbus TCP client that reads the live block.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "firmware/base/result.h"

namespace adit::host {

/// What a PLC takes from one read of registers 100 to 141.
struct LiveBlock {
  std::uint16_t epoch = 0, state = 0, validity = 0, age_ms = 0;
  std::optional<std::array<double, 3>> offset_m;           ///< E, N, H from the origin; absent: not available
  std::uint16_t sigma_horizontal = 0, sigma_vertical = 0;  ///< 0.1 mm, 65535 n/a
  std::uint32_t faults = 0;
  bool crc_good = false, whole = false;  ///< register 141 holds; 100 and 140 are of one epoch
};

/// One connection (libmodbus).
class Plc {
 public:
  static base::Result<Plc> Connect(const std::string& address, int port);
  ~Plc();
  Plc(Plc&&) noexcept;
  Plc& operator=(Plc&&) noexcept;

  /// The registers 0 and 1 say ADIT, and the constants 4 to 8 come in the right word order.
  base::Result<void> CheckIdentity();
  base::Result<LiveBlock> ReadLive();

 private:
  struct Connection;
  explicit Plc(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace adit::host
