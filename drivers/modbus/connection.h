// One client of the Modbus TCP server.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/modbus/mbap.h"
#include "firmware/base/time.h"
#include "hal/request_handler.h"

namespace adit::modbus {

enum class ConnectionFate : std::uint8_t { kStays, kClosed, kMalformed };

/// Owns its non-blocking socket. Answers are held until the client takes them; while it does not, its
/// requests are not read, so that memory stays fixed. Times are of a clock that only moves forward.
class Connection {
 public:
  Connection(int socket, std::uint32_t peer, base::TimeNs now_ns);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Reads, answers and writes as far as it goes without waiting; `requests` counts what was answered or
  /// met with silence.
  ConnectionFate Serve(base::TimeNs now_ns, hal::RequestHandler& handler, std::uint64_t& requests);

  bool WantsToWrite() const { return sent_ < held_; }
  int Socket() const { return socket_; }
  std::uint32_t Peer() const { return peer_; }
  /// Of the last complete request, or of the connection.
  base::TimeNs ActiveNs() const { return active_ns_; }
  /// When the request that is incomplete now began; kNever if there is none.
  base::TimeNs PartialSinceNs() const { return partial_since_ns_; }

 private:
  enum class ReadOutcome : std::uint8_t { kBytes, kNothing, kEnd };

  bool Flush();
  ReadOutcome ReadSome();
  void AnswerWaiting(base::TimeNs now_ns, hal::RequestHandler& handler, std::uint64_t& requests);

  int socket_;
  std::uint32_t peer_;
  base::TimeNs active_ns_;
  base::TimeNs partial_since_ns_ = base::kNever;
  MbapStream stream_;
  std::array<std::uint8_t, 4 * kFrameMax> answers_{};
  std::size_t held_ = 0;  ///< bytes in answers_
  std::size_t sent_ = 0;  ///< of these already taken by the kernel
};

}  // namespace adit::modbus
