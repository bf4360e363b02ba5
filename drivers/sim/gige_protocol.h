// The packets of GigE Vision 2.0, parsed and made: pure functions of bytes. GVCP is control, GVSP the image
// stream.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace adit::sim {

/// GVCP commands that the simulated camera knows; an acknowledge is the command plus one.
enum class GvcpCode : std::uint16_t {
  kDiscovery = 0x0002,
  kPacketResend = 0x0040,
  kReadRegister = 0x0080,
  kWriteRegister = 0x0082,
  kReadMemory = 0x0084,
  kWriteMemory = 0x0086,
};

/// Status codes of acknowledges (GigE Vision 2.0, table 19-1).
enum class GvcpStatus : std::uint16_t {
  kSuccess = 0x0000,
  kNotImplemented = 0x8001,
  kInvalidParameter = 0x8002,
  kInvalidAddress = 0x8003,
  kWriteProtect = 0x8004,
  kBadAlignment = 0x8005,
  kAccessDenied = 0x8006,
};

/// The most that a control packet may carry behind its header: 576 bytes less the headers of IP, UDP and
/// GVCP.
inline constexpr std::size_t kGvcpMaxPayloadBytes = 540;

struct GvcpCommand {
  GvcpCode code{};
  std::uint16_t code_number = 0;  ///< also of commands that `code` has no name for
  bool wants_acknowledge = false;
  std::uint16_t id = 0;
  std::span<const std::uint8_t> payload;  ///< of the packet it was parsed from
};

/// Declines packets that are too short or too long, have no command key, or another length than they say.
std::optional<GvcpCommand> ParseGvcp(std::span<const std::uint8_t> packet);

/// An acknowledge of `command` with that payload.
std::vector<std::uint8_t> FormatAcknowledge(const GvcpCommand& command, GvcpStatus status,
                                            std::span<const std::uint8_t> payload);

/// A range of packets of one frame, asked for again.
struct ResendRequest {
  std::uint16_t frame_id = 0;
  std::uint32_t first = 0, last = 0;
};
std::optional<ResendRequest> ParseResend(std::span<const std::uint8_t> payload);

/// Big-endian access; `at` must leave room.
std::uint32_t ReadU32(std::span<const std::uint8_t> bytes, std::size_t at);
void WriteU32(std::span<std::uint8_t> bytes, std::size_t at, std::uint32_t value);

inline constexpr std::size_t kGvspHeaderBytes = 8;
inline constexpr std::size_t kGvspLeaderBytes = kGvspHeaderBytes + 36;
inline constexpr std::size_t kGvspTrailerBytes = kGvspHeaderBytes + 8;
/// What of a packet's size IP and UDP take.
inline constexpr std::size_t kIpUdpBytes = 28;

enum class GvspContent : std::uint8_t { kLeader = 1, kTrailer = 2, kPayload = 3 };

/// Frame ids are of 16 bits and never 0.
constexpr std::uint16_t NextFrameId(std::uint16_t id) {
  return id == 0xFFFF ? 1 : static_cast<std::uint16_t>(id + 1);
}

struct GvspFrame {
  std::uint16_t id = 0;
  std::uint64_t timestamp_ns = 0;
  std::uint32_t pixel_format = 0;  ///< PFNC
  std::uint32_t width_px = 0, height_px = 0;
};

std::array<std::uint8_t, kGvspHeaderBytes> FormatGvspHeader(std::uint16_t frame_id, GvspContent content,
                                                            std::uint32_t packet_id);
std::array<std::uint8_t, kGvspLeaderBytes> FormatLeader(const GvspFrame& frame);
std::array<std::uint8_t, kGvspTrailerBytes> FormatTrailer(const GvspFrame& frame, std::uint32_t packet_id);

}  // namespace adit::sim
