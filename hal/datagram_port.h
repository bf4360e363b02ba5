// Where datagrams go.
#pragma once

#include <span>

namespace adit::hal {

/// One receiver. Send belongs to one thread and never blocks; what cannot go out now is lost, as datagrams
/// are.
class DatagramPort {
 public:
  virtual ~DatagramPort() = default;
  virtual void Send(std::span<const char> datagram) = 0;
};

}  // namespace adit::hal
