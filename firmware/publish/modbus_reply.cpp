#include "firmware/publish/modbus_reply.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace adit::publish {
namespace {

// Modbus Application Protocol V1.1b3, sections 6 and 7.
enum class Function : std::uint8_t {
  kReadDiscreteInputs = 0x02,
  kReadHoldingRegisters = 0x03,
  kReadInputRegisters = 0x04,
  kEncapsulated = 0x2B,
};
enum class ModbusException : std::uint8_t {
  kNone = 0,
  kIllegalFunction = 0x01,
  kIllegalAddress = 0x02,
  kIllegalValue = 0x03,
  kNoSuchUnit = 0x0B,  // "gateway target device failed to respond"
};
constexpr std::uint8_t kExceptionFlag = 0x80;
constexpr std::uint8_t kDeviceIdentification = 0x0E;
constexpr unsigned kRegistersMax = 125;
constexpr unsigned kBitsMax = 2000;
constexpr std::size_t kReadRequestLength = 6;      // unit, function, first, count
constexpr std::size_t kIdentifyRequestLength = 5;  // unit, function, MEI type, category, object

// Appends to the reply, whose room is checked once by Answer.
struct Writer {
  std::span<std::uint8_t> bytes;
  std::size_t size = 0;

  void Byte(unsigned value) { bytes[size++] = static_cast<std::uint8_t>(value & 0xFFU); }
  void Text(std::string_view text) {
    for (const char c : text) Byte(static_cast<unsigned char>(c));
  }
};

unsigned WordAt(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] * 256U + bytes[at + 1];
}

ModbusException ReadRegisters(std::span<const std::uint8_t> request, const RegisterImage& image,
                              Writer& reply) {
  if (request.size() != kReadRequestLength) return ModbusException::kIllegalValue;
  const unsigned first = WordAt(request, 2), count = WordAt(request, 4);
  if (count < 1 || count > kRegistersMax) return ModbusException::kIllegalValue;
  if (!RegistersExist(first, count)) return ModbusException::kIllegalAddress;
  reply.Byte(2 * count);
  for (unsigned i = 0; i < count; ++i) {
    reply.Byte(image.words[first + i] >> 8);
    reply.Byte(image.words[first + i]);
  }
  return ModbusException::kNone;
}

ModbusException ReadBits(std::span<const std::uint8_t> request, const RegisterImage& image, Writer& reply) {
  if (request.size() != kReadRequestLength) return ModbusException::kIllegalValue;
  const unsigned first = WordAt(request, 2), count = WordAt(request, 4);
  if (count < 1 || count > kBitsMax) return ModbusException::kIllegalValue;
  if (first + count > kDiscreteInputs) return ModbusException::kIllegalAddress;
  const unsigned bits = (static_cast<unsigned>(image.discrete_inputs) >> first) & ((1U << count) - 1);
  reply.Byte((count + 7) / 8);
  for (unsigned i = 0; i < (count + 7) / 8; ++i) reply.Byte(bits >> (8 * i));
  return ModbusException::kNone;
}

struct IdentityObject {
  std::uint8_t id;
  std::uint8_t category;  // 1 basic, 2 regular, 3 extended
  std::string_view text;
};
constexpr std::uint8_t kCategories = 3;
constexpr std::uint8_t kSingleObject = 4;

ModbusException Identify(std::span<const std::uint8_t> request, const BoxIdentity& identity, Writer& reply) {
  if (request.size() >= 3 && request[2] != kDeviceIdentification) return ModbusException::kIllegalFunction;
  if (request.size() != kIdentifyRequestLength) return ModbusException::kIllegalValue;
  const std::array<IdentityObject, 5> objects{{{0x00, 1, TextOf(identity.vendor)},
                                               {0x01, 1, "ADIT"},
                                               {0x02, 1, TextOf(identity.version)},
                                               {0x04, 2, TextOf(identity.product)},
                                               {0x80, 3, TextOf(identity.serial)}}};
  const unsigned category = request[3], wanted = request[4];
  if (category < 1 || category > kSingleObject) return ModbusException::kIllegalValue;
  const bool single = category == kSingleObject;
  const bool known = std::ranges::any_of(objects, [&](const IdentityObject& object) {
    return object.id == wanted && (single || object.category <= category);
  });
  if (single && !known) return ModbusException::kIllegalAddress;
  // Section 6.21: a stream from an object that is not there starts at the first.
  const unsigned first = known ? wanted : 0;
  constexpr unsigned kConformity = 0x80 + kCategories;  // up to extended, as stream and one by one
  for (const unsigned value : {unsigned{kDeviceIdentification}, category, kConformity, 0U, 0U})
    reply.Byte(value);
  const std::size_t count_at = reply.size;
  reply.Byte(0);
  for (const IdentityObject& object : objects) {
    const bool part = single ? object.id == wanted : object.id >= first && object.category <= category;
    if (!part) continue;
    ++reply.bytes[count_at];
    reply.Byte(object.id);
    reply.Byte(static_cast<unsigned>(object.text.size()));
    reply.Text(object.text);
  }
  return ModbusException::kNone;
}

}  // namespace

std::size_t ModbusResponder::Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply,
                                    base::TimeNs now_ns) const {
  if (request.size() < 2 || reply.size() < kMaxModbusMessage) return 0;
  const std::uint8_t unit = request[0];
  Writer writer{reply};
  writer.Byte(unit);
  writer.Byte(request[1]);
  ModbusException exception = ModbusException::kIllegalFunction;
  RegisterImage image;
  if (unit != unit_ && unit != 0 && unit != 255) {
    exception = ModbusException::kNoSuchUnit;
  } else {
    switch (static_cast<Function>(request[1])) {
      case Function::kReadDiscreteInputs:
        map_.Read(now_ns, image);
        exception = ReadBits(request, image, writer);
        break;
      case Function::kReadHoldingRegisters:
      case Function::kReadInputRegisters:
        map_.Read(now_ns, image);
        exception = ReadRegisters(request, image, writer);
        break;
      case Function::kEncapsulated:
        exception = Identify(request, map_.Identity(), writer);
        break;
    }
  }
  if (exception == ModbusException::kNone) return writer.size;
  writer.size = 1;
  writer.Byte(request[1] | kExceptionFlag);
  writer.Byte(static_cast<unsigned>(exception));
  return writer.size;
}

}  // namespace adit::publish
