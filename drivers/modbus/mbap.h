// Framing of Modbus TCP: the MBAP header, and the stream of bytes cut into requests.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace adit::modbus {

/// Transaction id, protocol id 0, length of what follows; each two bytes, high byte first (Modbus Messaging
/// on TCP/IP Implementation Guide V1.0b, 3.1.3). The unit id is counted as part of the message here.
inline constexpr std::size_t kMbapLength = 6;
inline constexpr std::size_t kMessageMin = 2;    ///< unit id, function code
inline constexpr std::size_t kMessageMax = 254;  ///< unit id, PDU of 253
inline constexpr std::size_t kFrameMax = kMbapLength + kMessageMax;

/// One request as it stands in the stream.
struct Frame {
  std::uint16_t transaction = 0;
  std::span<const std::uint8_t> message;  ///< unit id and PDU; valid until the next Consume
};

/// Collects bytes of one connection. No heap.
class MbapStream {
 public:
  /// Room for the next bytes; never empty unless a whole frame waits to be taken.
  std::span<std::uint8_t> Room() { return std::span(bytes_).subspan(size_); }
  /// `count` bytes were written to Room().
  void Fill(std::size_t count) { size_ += count; }

  /// Whether what stands first cannot be Modbus: a wrong protocol id or length. There is no way to find the
  /// next request then; the connection must be closed.
  bool Malformed() const;
  /// The first request, if it is complete and well formed.
  std::optional<Frame> First() const;
  /// Drops the first request.
  void Consume();
  /// Whether bytes wait that make no whole request yet.
  bool Partial() const { return size_ > 0 && !First(); }

 private:
  std::size_t FirstLength() const;

  // A few requests that were sent without waiting fit at once.
  std::array<std::uint8_t, 4 * kFrameMax> bytes_{};
  std::size_t size_ = 0;
};

/// Puts the header of an answer of `message_length` in front of it; `frame` holds kMbapLength bytes.
void WriteMbap(std::span<std::uint8_t, kMbapLength> header, std::uint16_t transaction,
               std::size_t message_length);

}  // namespace adit::modbus
