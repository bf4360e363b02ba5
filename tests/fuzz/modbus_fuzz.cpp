// Arbitrary bytes through the Modbus server's framing and the box's answers.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/modbus/mbap.h"
#include "firmware/base/require.h"
#include "firmware/publish/modbus_reply.h"

namespace {

using adit::modbus::MbapStream;
using adit::publish::kMaxModbusMessage;

const adit::publish::RegisterMap& Map() {
  static const adit::publish::RegisterMap map(adit::publish::MakeIdentity("4711", "1.2.3", 1), {});
  return map;
}

// Whatever was asked: the unit and function of the request, or the same as exception; never too long.
void CheckAnswer(std::span<const std::uint8_t> request) {
  static const adit::publish::ModbusResponder responder(Map(), 1);
  std::array<std::uint8_t, kMaxModbusMessage> reply{};
  const std::size_t length = responder.Answer(request, reply, 0);
  if (request.size() < 2) {
    ADIT_REQUIRE(length == 0);
    return;
  }
  ADIT_REQUIRE(length >= 3 && length <= reply.size());
  ADIT_REQUIRE(reply[0] == request[0] && (reply[1] & 0x7F) == (request[1] & 0x7F));
}

// Makes whole frames of the bytes: their headers as a client writes them, the messages as they are.
void RepairHeaders(std::span<std::uint8_t> bytes) {
  for (std::size_t at = 0; at + adit::modbus::kMbapLength <= bytes.size();) {
    bytes[at + 2] = bytes[at + 3] = bytes[at + 4] = 0;
    const std::size_t length = adit::modbus::kMessageMin + bytes[at + 5] % (adit::modbus::kMessageMax - 1);
    bytes[at + 5] = static_cast<std::uint8_t>(length);
    at += adit::modbus::kMbapLength + length;
  }
}

void Stream(std::span<const std::uint8_t> bytes, std::size_t piece) {
  MbapStream stream;
  for (std::size_t at = 0; at < bytes.size() && !stream.Malformed();) {
    const std::span<std::uint8_t> room = stream.Room();
    ADIT_REQUIRE(!room.empty());
    const std::size_t count = std::min({piece, bytes.size() - at, room.size()});
    std::ranges::copy(bytes.subspan(at, count), room.begin());
    stream.Fill(count);
    at += count;
    for (auto frame = stream.First(); frame; frame = stream.First()) {
      CheckAnswer(frame->message);
      stream.Consume();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  CheckAnswer({data, size});
  if (size == 0) return 0;
  // The first byte says how the rest arrives: in pieces of which size, and framed by somebody who knows how
  // or not.
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  if ((data[0] & 0x80) == 0) RepairHeaders(bytes);
  Stream(bytes, data[0] % 64 + std::size_t{1});
  return 0;
}
