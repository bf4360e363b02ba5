#include "drivers/linux/udp_port.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace adit::linux {

base::Result<std::unique_ptr<UdpPort>> UdpPort::Open(const std::string& address, int port) {
  const std::string where = "UDP " + address + ":" + std::to_string(port);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1)
    return base::Error{base::ErrorCode::kOutOfRange, where, "is no IPv4 address"};
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || connect(socket.Get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
    return base::Error{base::ErrorCode::kUnavailable, where, std::strerror(errno)};
  return std::unique_ptr<UdpPort>(new UdpPort(std::move(socket)));
}

void UdpPort::Send(std::span<const char> datagram) {
  // A receiver that is not there answers by ICMP, which the next send would report: no error of ours.
  (void)send(socket_.Get(), datagram.data(), datagram.size(), MSG_NOSIGNAL);
}

}  // namespace adit::linux
