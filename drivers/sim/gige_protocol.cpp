#include "drivers/sim/gige_protocol.h"

#include <algorithm>

namespace adit::sim {
namespace {

constexpr std::size_t kGvcpHeaderBytes = 8;
constexpr std::uint8_t kCommandKey = 0x42;
constexpr std::uint8_t kFlagAcknowledge = 0x01;
constexpr std::uint16_t kPayloadImage = 1;

std::uint16_t ReadU16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void WriteU16(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value >> 8);
  bytes[at + 1] = static_cast<std::uint8_t>(value);
}

}  // namespace

std::uint32_t ReadU32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(ReadU16(bytes, at)) << 16 | ReadU16(bytes, at + 2);
}

void WriteU32(std::span<std::uint8_t> bytes, std::size_t at, std::uint32_t value) {
  WriteU16(bytes, at, static_cast<std::uint16_t>(value >> 16));
  WriteU16(bytes, at + 2, static_cast<std::uint16_t>(value));
}

std::optional<GvcpCommand> ParseGvcp(std::span<const std::uint8_t> packet) {
  if (packet.size() < kGvcpHeaderBytes || packet[0] != kCommandKey) return std::nullopt;
  if (packet.size() > kGvcpHeaderBytes + kGvcpMaxPayloadBytes) return std::nullopt;
  if (ReadU16(packet, 4) != packet.size() - kGvcpHeaderBytes) return std::nullopt;
  GvcpCommand command;
  command.wants_acknowledge = (packet[1] & kFlagAcknowledge) != 0;
  command.code_number = ReadU16(packet, 2);
  command.code = static_cast<GvcpCode>(command.code_number);
  command.id = ReadU16(packet, 6);
  command.payload = packet.subspan(kGvcpHeaderBytes);
  return command;
}

std::vector<std::uint8_t> FormatAcknowledge(const GvcpCommand& command, GvcpStatus status,
                                            std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> packet(kGvcpHeaderBytes + payload.size());
  WriteU16(packet, 0, static_cast<std::uint16_t>(status));
  WriteU16(packet, 2, static_cast<std::uint16_t>(command.code_number + 1));
  WriteU16(packet, 4, static_cast<std::uint16_t>(payload.size()));
  WriteU16(packet, 6, command.id);
  std::copy(payload.begin(), payload.end(), packet.begin() + kGvcpHeaderBytes);
  return packet;
}

std::optional<ResendRequest> ParseResend(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kBytes = 12;
  constexpr std::uint32_t kPacketIdMask = 0x00FFFFFF;
  if (payload.size() < kBytes) return std::nullopt;
  const ResendRequest request{ReadU16(payload, 2), ReadU32(payload, 4) & kPacketIdMask,
                              ReadU32(payload, 8) & kPacketIdMask};
  if (request.first > request.last) return std::nullopt;
  return request;
}

std::array<std::uint8_t, kGvspHeaderBytes> FormatGvspHeader(std::uint16_t frame_id, GvspContent content,
                                                            std::uint32_t packet_id) {
  std::array<std::uint8_t, kGvspHeaderBytes> header{};
  WriteU16(header, 2, frame_id);
  WriteU32(header, 4, packet_id);
  header[4] = static_cast<std::uint8_t>(content);
  return header;
}

std::array<std::uint8_t, kGvspLeaderBytes> FormatLeader(const GvspFrame& frame) {
  std::array<std::uint8_t, kGvspLeaderBytes> packet{};
  const auto header = FormatGvspHeader(frame.id, GvspContent::kLeader, 0);
  std::copy(header.begin(), header.end(), packet.begin());
  WriteU16(packet, kGvspHeaderBytes + 2, kPayloadImage);
  WriteU32(packet, kGvspHeaderBytes + 4, static_cast<std::uint32_t>(frame.timestamp_ns >> 32));
  WriteU32(packet, kGvspHeaderBytes + 8, static_cast<std::uint32_t>(frame.timestamp_ns));
  WriteU32(packet, kGvspHeaderBytes + 12, frame.pixel_format);
  WriteU32(packet, kGvspHeaderBytes + 16, frame.width_px);
  WriteU32(packet, kGvspHeaderBytes + 20, frame.height_px);
  return packet;
}

std::array<std::uint8_t, kGvspTrailerBytes> FormatTrailer(const GvspFrame& frame, std::uint32_t packet_id) {
  std::array<std::uint8_t, kGvspTrailerBytes> packet{};
  const auto header = FormatGvspHeader(frame.id, GvspContent::kTrailer, packet_id);
  std::copy(header.begin(), header.end(), packet.begin());
  WriteU16(packet, kGvspHeaderBytes + 2, kPayloadImage);
  WriteU32(packet, kGvspHeaderBytes + 4, frame.height_px);
  return packet;
}

}  // namespace adit::sim
