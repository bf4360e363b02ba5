// Datagrams to one receiver by UDP.
#pragma once

#include <memory>
#include <string>

#include "drivers/linux/file_descriptor.h"
#include "firmware/base/result.h"
#include "hal/datagram_port.h"

namespace adit::linux {

class UdpPort final : public hal::DatagramPort {
 public:
  /// `address` is an IPv4 one. Declines with address and port.
  static base::Result<std::unique_ptr<UdpPort>> Open(const std::string& address, int port);
  void Send(std::span<const char> datagram) override;

 private:
  explicit UdpPort(FileDescriptor socket) : socket_(std::move(socket)) {}
  FileDescriptor socket_;
};

}  // namespace adit::linux
