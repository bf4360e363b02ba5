#include "drivers/sim/gige_registers.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace adit::sim {
namespace {

constexpr std::size_t kMemoryBytes = 0x30000;
constexpr std::uint32_t kXmlAddress = 0x20000;
constexpr std::uint32_t kHeartbeatMs = 3000;  // the standard's default

/// Where a controlling application may write.
struct WriteRange {
  std::uint32_t first, last;
};
constexpr std::array<WriteRange, 5> kWritable{{{0x0938, 0x093B},              // heartbeat timeout
                                               {0x0A00, 0x0A03},              // control channel privilege
                                               {0x0B00, 0x0D3F},              // message and stream channels
                                               {0x10000, kRegPtpStatus - 1},  // the camera's own
                                               {kRegPayload + 4, 0x10FFF}}};

}  // namespace

GigeRegisters::GigeRegisters(const GigeIdentity& identity) : memory_(kMemoryBytes) {
  Set(0x0000, 0x00020000);  // GigE Vision 2.0
  Set(0x0004, 0x80000001);  // big endian, UTF-8
  Set(0x0008, 0x0000'02AD);
  Set(0x000C, identity.address);  // a MAC address made of the IP address, locally administered
  Set(0x0010, 0x00000007);
  Set(0x0014, 0x00000005);
  Set(0x0024, identity.address);
  Set(0x0034, 0xFF000000);
  SetText(0x0048, "adit", 32);
  SetText(0x0068, "simulated camera", 32);
  SetText(0x0088, "1.0", 32);
  SetText(0x00A8, "not a real camera", 48);
  SetText(0x00D8, identity.serial, 16);
  const std::string xml = GigeXml(identity);
  std::array<char, 64> url{};
  std::snprintf(url.data(), url.size(), "Local:adit.xml;%x;%zx", kXmlAddress, xml.size());
  SetText(0x0200, url.data(), 512);
  Set(0x0600, 1);           // one network interface
  Set(0x0904, 1);           // one stream channel
  Set(0x0934, 0x40000006);  // serial number, resend, write memory
  Set(kRegHeartbeatMs, kHeartbeatMs);
  Set(0x0940, 1'000'000'000);  // ticks a second: nanoseconds
  Set(kRegPacketSize, 1500);
  Set(kRegWidth, static_cast<std::uint32_t>(identity.width_px));
  Set(kRegHeight, static_cast<std::uint32_t>(identity.height_px));
  Set(kRegPixelFormat, kMono8);
  Set(kRegPayload, static_cast<std::uint32_t>(identity.width_px * identity.height_px));
  std::copy(xml.begin(), xml.end(), memory_.begin() + kXmlAddress);
}

std::optional<std::span<const std::uint8_t>> GigeRegisters::Read(std::uint32_t address,
                                                                 std::size_t bytes) const {
  if (address > memory_.size() || bytes > memory_.size() - address) return std::nullopt;
  return std::span<const std::uint8_t>(memory_).subspan(address, bytes);
}

std::optional<std::uint32_t> GigeRegisters::ReadWord(std::uint32_t address) const {
  const auto bytes = Read(address, 4);
  if (!bytes) return std::nullopt;
  return ReadU32(*bytes, 0);
}

GvcpStatus GigeRegisters::Write(std::uint32_t address, std::span<const std::uint8_t> bytes) {
  if (address >= memory_.size() || bytes.size() > memory_.size() - address)
    return GvcpStatus::kInvalidAddress;
  if (address % 4 != 0 || bytes.size() % 4 != 0) return GvcpStatus::kBadAlignment;
  const bool permitted = std::any_of(kWritable.begin(), kWritable.end(), [&](const WriteRange& range) {
    return address >= range.first && address + bytes.size() <= range.last + 1;
  });
  if (!permitted) return GvcpStatus::kWriteProtect;
  std::copy(bytes.begin(), bytes.end(), memory_.begin() + address);
  const std::uint32_t pixel_bytes = *ReadWord(kRegPixelFormat) == kMono8 ? 1 : 2;
  Set(kRegPayload, *ReadWord(kRegWidth) * *ReadWord(kRegHeight) * pixel_bytes);
  return GvcpStatus::kSuccess;
}

void GigeRegisters::Set(std::uint32_t address, std::uint32_t value) { WriteU32(memory_, address, value); }

void GigeRegisters::SetText(std::uint32_t address, const std::string& text, std::size_t room) {
  std::copy_n(text.begin(), std::min(text.size(), room - 1), memory_.begin() + address);
}

}  // namespace adit::sim
