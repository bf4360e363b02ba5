#include "host/plc.h"

#include <modbus.h>

#include <bit>
#include <boost/crc.hpp>
#include <cerrno>
#include <vector>

namespace adit::host {

struct Plc::Connection {
  modbus_t* context = nullptr;
  std::string name;
  ~Connection() {
    modbus_close(context);
    modbus_free(context);
  }
  base::Error Failed(const char* what) const {
    return {base::ErrorCode::kUnavailable, name, std::string(what) + " failed: " + modbus_strerror(errno)};
  }
};

namespace {

std::int32_t Signed32(const std::uint16_t* words) {
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(words[0]) << 16) | words[1]);
}

/// CRC-16/CCITT-FALSE by Boost, which shares no code with the box: over the registers as sent, then 0xFF
/// 0xA0.
std::uint16_t LiveCrc(const std::array<std::uint16_t, 42>& live) {
  boost::crc_optimal<16, 0x1021, 0xFFFF, 0, false, false> crc;
  for (std::size_t i = 0; i + 1 < live.size(); ++i) {
    crc.process_byte(static_cast<unsigned char>(live[i] >> 8));
    crc.process_byte(static_cast<unsigned char>(live[i] & 0xFF));
  }
  crc.process_byte(0xFF);
  crc.process_byte(0xA0);
  return static_cast<std::uint16_t>(crc.checksum());
}

}  // namespace

Plc::Plc(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
Plc::~Plc() = default;
Plc::Plc(Plc&&) noexcept = default;
Plc& Plc::operator=(Plc&&) noexcept = default;

base::Result<Plc> Plc::Connect(const std::string& address, int port) {
  auto connection = std::make_unique<Connection>();
  connection->name = address + ":" + std::to_string(port);
  connection->context = modbus_new_tcp(address.c_str(), port);
  if (connection->context == nullptr || modbus_connect(connection->context) != 0)
    return connection->Failed("connecting");
  return Plc(std::move(connection));
}

base::Result<void> Plc::CheckIdentity() {
  std::array<std::uint16_t, 9> words{};
  if (modbus_read_input_registers(connection_->context, 0, 9, words.data()) != 9)
    return connection_->Failed("reading 0-8");
  const bool good = words[0] == 0x4144 && words[1] == 0x4954 && Signed32(&words[4]) == 0x12345678 &&
                    std::bit_cast<float>(Signed32(&words[6])) == 123.456F && words[8] == 0xFFFE;
  if (!good) return base::Error{base::ErrorCode::kFailed, connection_->name, "registers 0-8 are not adit's"};
  return {};
}

base::Result<LiveBlock> Plc::ReadLive() {
  std::array<std::uint16_t, 42> words{};
  if (modbus_read_input_registers(connection_->context, 100, 42, words.data()) != 42) {
    return connection_->Failed("reading 100-141");
  }
  LiveBlock live;
  live.epoch = words[0], live.state = words[1], live.validity = words[2], live.age_ms = words[3];
  const std::array<std::int32_t, 3> tenths{Signed32(&words[4]), Signed32(&words[6]), Signed32(&words[8])};
  if (tenths[0] != INT32_MIN && tenths[1] != INT32_MIN && tenths[2] != INT32_MIN) {
    live.offset_m = {tenths[0] * 1e-4, tenths[1] * 1e-4, tenths[2] * 1e-4};
  }
  live.sigma_horizontal = words[16], live.sigma_vertical = words[17];
  live.faults = static_cast<std::uint32_t>(Signed32(&words[20]));
  live.whole = words[0] == words[40];
  live.crc_good = LiveCrc(words) == words[41];
  return live;
}

}  // namespace adit::host
