// A TCP client on loopback that does what no Modbus library would.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <vector>

namespace adit::modbus {

using Bytes = std::vector<std::uint8_t>;

class PlainClient {
 public:
  explicit PlainClient(std::uint16_t port, const std::string& from = "127.0.0.1",
                       int receive_buffer_bytes = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer_bytes > 0) {
      (void)::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
    }
    sockaddr_in address = Address(from, 0);
    (void)::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    address = Address("127.0.0.1", port);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~PlainClient() { ::close(socket_); }
  PlainClient(const PlainClient&) = delete;
  PlainClient& operator=(const PlainClient&) = delete;

  bool Connected() const { return connected_; }
  bool Send(const Bytes& bytes) const {
    return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  /// What does not fit is left out; returns the bytes taken.
  std::size_t SendWithoutWaiting(const Bytes& bytes) const {
    const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return count < 0 ? 0 : static_cast<std::size_t>(count);
  }
  void EndSending() const { (void)::shutdown(socket_, SHUT_WR); }

  /// Exactly `count` bytes, fewer if they do not come within `limit_ms` each or the server closes.
  Bytes Receive(std::size_t count, int limit_ms = 2000) const {
    Bytes bytes;
    while (bytes.size() < count) {
      pollfd waiting{socket_, POLLIN, 0};
      if (::poll(&waiting, 1, limit_ms) <= 0) break;
      std::uint8_t chunk[4096];
      const ssize_t got = ::recv(socket_, chunk, std::min(sizeof chunk, count - bytes.size()), 0);
      if (got <= 0) break;
      bytes.insert(bytes.end(), chunk, chunk + got);
    }
    return bytes;
  }
  /// Whether the server closes within `limit_ms`, without another byte.
  bool IsClosed(int limit_ms = 2000) const {
    pollfd waiting{socket_, POLLIN, 0};
    std::uint8_t byte = 0;
    return ::poll(&waiting, 1, limit_ms) == 1 && ::recv(socket_, &byte, 1, 0) <= 0;
  }

 private:
  static sockaddr_in Address(const std::string& host, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    (void)::inet_pton(AF_INET, host.c_str(), &address.sin_addr);
    return address;
  }

  int socket_;
  bool connected_ = false;
};

}  // namespace adit::modbus
