// The door of a Modbus TCP server: accepts, frames, limits. What it answers is its handler's business.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/base/time.h"
#include "hal/request_handler.h"

namespace adit::modbus {

struct ServerOptions {
  std::string bind = "0.0.0.0";  ///< IPv4 address to listen on
  std::uint16_t port = 502;      ///< 0: any free port
  std::size_t connections_max = 32;
  std::size_t connections_per_peer = 8;
  std::vector<std::string> admitted;  ///< IPv4 addresses that always get in; an idle stranger makes room
  base::DurationNs partial_limit_ns = 2 * base::kNsPerS;  ///< a request begun must be complete by then
  base::DurationNs idle_limit_ns = 120 * base::kNsPerS;   ///< without a complete request
};

/// What the server counts; monotonic since Open, but for `clients`.
struct ServerHealth {
  std::uint64_t requests = 0;
  std::uint64_t accepted = 0;
  std::uint64_t refused = 0;    ///< connections over a limit
  std::uint64_t malformed = 0;  ///< connections closed for a wrong protocol id or length
  std::uint64_t timed_out = 0;  ///< connections closed for a partial frame or idleness
  std::uint32_t clients = 0;    ///< now
};

/// One thread, non-blocking sockets: a client that drips, stalls or floods costs the others nothing.
/// Requests that a client sends without waiting are answered in their order. A client that does not read
/// its answers is not read either.
class ModbusServer {
 public:
  /// Binds, listens and starts the thread. Declines with address and port. `handler` is called from that
  /// thread with unit id and PDU (the MBAP header without its first six bytes), answers in the same shape,
  /// and must outlive the server.
  static base::Result<std::unique_ptr<ModbusServer>> Open(const ServerOptions& options,
                                                          hal::RequestHandler& handler);
  /// Closes all connections and ends the thread.
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  /// The port it listens on.
  std::uint16_t Port() const;
  /// Any thread.
  ServerHealth Health() const;

 private:
  class Loop;
  explicit ModbusServer(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace adit::modbus
