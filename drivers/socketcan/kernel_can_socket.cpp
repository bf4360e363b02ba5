#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/socketcan/can_socket.h"

namespace adit::socketcan {
namespace {

base::Error Decline(const std::string& interface_name, const std::string& detail) {
  return {base::ErrorCode::kUnavailable, interface_name, detail};
}

ifreq RequestFor(const std::string& interface_name) {
  ifreq request{};
  std::copy_n(interface_name.begin(), std::min(interface_name.size(), sizeof(request.ifr_name) - 1),
              request.ifr_name);
  return request;
}

ReceivedFrame Decode(const can_frame& raw, int flags) {
  ReceivedFrame received;
  received.error = (raw.can_id & CAN_ERR_FLAG) != 0;
  received.error_class = received.error ? raw.can_id & CAN_ERR_MASK : 0;
  // MSG_CONFIRM marks what this very socket sent (Documentation/networking/can.rst, 4.1.7).
  received.own = (flags & MSG_CONFIRM) != 0;
  received.frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  received.frame.id = raw.can_id & (received.frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  received.frame.length = std::min<std::uint8_t>(raw.can_dlc, CAN_MAX_DLEN);
  std::copy_n(raw.data, received.frame.length, received.frame.data.begin());
  return received;
}

class KernelCanSocket final : public CanSocket {
 public:
  KernelCanSocket(int socket, std::string interface_name)
      : socket_(socket), interface_name_(std::move(interface_name)) {}
  ~KernelCanSocket() override { ::close(socket_); }
  KernelCanSocket(const KernelCanSocket&) = delete;
  KernelCanSocket& operator=(const KernelCanSocket&) = delete;

  WriteOutcome Write(const base::CanFrame& frame) override {
    can_frame raw{};
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U);
    raw.can_dlc = frame.length;
    std::copy_n(frame.data.begin(), frame.length, raw.data);
    if (::write(socket_, &raw, sizeof raw) == static_cast<ssize_t>(sizeof raw)) return WriteOutcome::kTaken;
    const bool full = errno == ENOBUFS || errno == EAGAIN || errno == EINTR;
    return full ? WriteOutcome::kFull : WriteOutcome::kDown;
  }

  std::optional<ReceivedFrame> Read() override {
    can_frame raw{};
    iovec part{&raw, sizeof raw};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    const ssize_t got = ::recvmsg(socket_, &message, MSG_DONTWAIT);
    if (got != static_cast<ssize_t>(sizeof raw)) return std::nullopt;
    return Decode(raw, message.msg_flags);
  }

  bool CycleInterface() override { return SetUp(false) && SetUp(true); }

 private:
  bool SetUp(bool up) const {
    ifreq request = RequestFor(interface_name_);
    if (::ioctl(socket_, SIOCGIFFLAGS, &request) != 0) return false;
    const unsigned flags = static_cast<unsigned short>(request.ifr_flags);
    constexpr unsigned kUp = IFF_UP;
    request.ifr_flags = static_cast<short>(up ? flags | kUp : flags & ~kUp);
    return ::ioctl(socket_, SIOCSIFFLAGS, &request) == 0;
  }

  int socket_;
  std::string interface_name_;
};

base::Result<void> Configure(int socket, const std::string& interface_name) {
  ifreq request = RequestFor(interface_name);
  if (::ioctl(socket, SIOCGIFINDEX, &request) != 0) {
    return Decline(interface_name, "there is no such network interface");
  }
  const int index = request.ifr_ifindex;
  if (::ioctl(socket, SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
    return Decline(interface_name, "is not a CAN interface");
  }
  const int own = 1;
  const can_err_mask_t errors = CAN_ERR_MASK;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  const bool done = ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &own, sizeof own) == 0 &&
                    ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0 &&
                    ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  if (done) return {};
  return Decline(interface_name, std::string("cannot be used: ") + std::strerror(errno));
}

}  // namespace

base::Result<std::unique_ptr<CanSocket>> OpenKernelCanSocket(const std::string& interface_name) {
  if (interface_name.empty() || interface_name.size() >= IFNAMSIZ) {
    return base::Error{base::ErrorCode::kOutOfRange, interface_name,
                       "the name of a network interface has 1 to 15 characters"};
  }
  const int socket = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket < 0) {
    return Decline(interface_name, std::string("this kernel has no CAN (") + std::strerror(errno) +
                                       "): load can-raw, or choose the driver candump");
  }
  if (auto configured = Configure(socket, interface_name); !configured) {
    ::close(socket);
    return configured.error();
  }
  return std::unique_ptr<CanSocket>(std::make_unique<KernelCanSocket>(socket, interface_name));
}

}  // namespace adit::socketcan
