// What a field bus server needs of the box: an answer to a request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace adit::hal {

/// Answers requests of one protocol. Called from the server's thread; must not block.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  /// Writes the answer to `request` (unit id and PDU, whole) into `reply`, in the same shape, and returns its
  /// length; 0 means silence.
  virtual std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply) = 0;
};

}  // namespace adit::hal
