#include "drivers/sim/gige_camera.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/linux/system_clock.h"

namespace adit::sim {
namespace {

constexpr std::uint16_t kGvcpPort = 3956;  // assigned to GigE Vision control
constexpr int kPollMs = 50;
constexpr std::uint32_t kPtpSlave = 9;  // IEEE 1588 port state
constexpr std::uint32_t kLimitedBroadcast = 0xFFFFFFFF, kLoopbackBroadcast = 0x7FFFFFFF;

bool SamePeer(const sockaddr_in& a, const sockaddr_in& b) {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

}  // namespace

GigeCamera::GigeCamera(const GigeOptions& options, FrameSource source)
    : options_(options),
      source_(std::move(source)),
      registers_(options.identity),
      next_id_(options.first_frame_id) {
  for (KeptFrame& frame : frames_) frame.pixels.resize(options.frame_bytes);
}

GigeCamera::~GigeCamera() { Stop(); }

base::Result<int> GigeCamera::Bind(std::uint32_t address, std::uint16_t port) const {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM, 0);
  const int on = 1;
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(port);
  name.sin_addr.s_addr = htonl(address);
  setsockopt(socket_fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  setsockopt(socket_fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof(on));
  if (socket_fd >= 0 && bind(socket_fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0)
    return socket_fd;
  const std::string reason = std::strerror(errno);
  if (socket_fd >= 0) close(socket_fd);
  return base::Error{base::ErrorCode::kUnavailable, "simulated camera " + options_.identity.serial,
                     "cannot bind UDP port " + std::to_string(port) + ": " + reason};
}

base::Result<void> GigeCamera::Start() {
  const std::array<std::uint32_t, 3> addresses{options_.identity.address, kLimitedBroadcast,
                                               kLoopbackBroadcast};
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    const auto bound = Bind(addresses[i], kGvcpPort);
    if (!bound) return bound.error();
    control_sockets_[i] = linux::FileDescriptor(*bound);
  }
  const auto stream = Bind(options_.identity.address, 0);
  if (!stream) return stream.error();
  stream_socket_ = linux::FileDescriptor(*stream);
  control_thread_ = std::thread([this] { Control(); });
  stream_thread_ = std::thread([this] { Stream(); });
  return {};
}

void GigeCamera::Stop() {
  stop_.store(true);
  if (control_thread_.joinable()) control_thread_.join();
  if (stream_thread_.joinable()) stream_thread_.join();
}

void GigeCamera::Control() {
  while (!stop_.load()) {
    std::array<pollfd, 3> polls{};
    for (std::size_t i = 0; i < polls.size(); ++i) polls[i] = {control_sockets_[i].Get(), POLLIN, 0};
    poll(polls.data(), polls.size(), kPollMs);
    for (const pollfd& ready : polls) {
      if ((ready.revents & POLLIN) != 0) Answer(ready.fd);
    }
    LetGoOfSilentController();
  }
}

void GigeCamera::Answer(int socket) {
  std::array<std::uint8_t, 2048> packet{};
  sockaddr_in peer{};
  socklen_t peer_bytes = sizeof(peer);
  const ssize_t got =
      recvfrom(socket, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&peer), &peer_bytes);
  if (got <= 0 || faults_.vanished.load()) return;
  const std::vector<std::uint8_t> reply = Reply({packet.data(), static_cast<std::size_t>(got)}, peer);
  // Whatever socket heard it, the answer comes from the camera's own address.
  if (!reply.empty()) {
    sendto(control_sockets_[0].Get(), reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&peer),
           peer_bytes);
  }
}

std::vector<std::uint8_t> GigeCamera::Reply(std::span<const std::uint8_t> packet, const sockaddr_in& peer) {
  const auto command = ParseGvcp(packet);
  if (!command) return {};
  const std::lock_guard lock(mutex_);
  if (SamePeer(peer, controller_)) last_heard_ns_ = linux::MonotonicNs();
  std::vector<std::uint8_t> reply = Obey(*command, peer);
  if (!command->wants_acknowledge) reply.clear();
  return reply;
}

std::vector<std::uint8_t> GigeCamera::Obey(const GvcpCommand& command, const sockaddr_in& peer) {
  switch (command.code) {
    case GvcpCode::kDiscovery:
      return FormatAcknowledge(command, GvcpStatus::kSuccess, *registers_.Read(0, 0xF8));
    case GvcpCode::kPacketResend: {
      if (const auto request = ParseResend(command.payload)) Resend(*request);
      return {};
    }
    case GvcpCode::kReadRegister:
      return ReadRegisters(command);
    case GvcpCode::kReadMemory:
      return ReadMemory(command);
    case GvcpCode::kWriteRegister:
      return WriteRegisters(command, peer);
    case GvcpCode::kWriteMemory:
      return WriteMemory(command, peer);
  }
  return FormatAcknowledge(command, GvcpStatus::kNotImplemented, {});
}

std::vector<std::uint8_t> GigeCamera::ReadRegisters(const GvcpCommand& command) const {
  const auto fail = [&](GvcpStatus status) { return FormatAcknowledge(command, status, {}); };
  if (command.payload.empty() || command.payload.size() % 4 != 0) return fail(GvcpStatus::kInvalidParameter);
  std::vector<std::uint8_t> values;
  for (std::size_t at = 0; at < command.payload.size(); at += 4) {
    const std::uint32_t address = ReadU32(command.payload, at);
    const auto word = registers_.Read(address, 4);
    if (!word) return fail(GvcpStatus::kInvalidAddress);
    if (address % 4 != 0) return fail(GvcpStatus::kBadAlignment);
    values.insert(values.end(), word->begin(), word->end());
  }
  return FormatAcknowledge(command, GvcpStatus::kSuccess, values);
}

std::vector<std::uint8_t> GigeCamera::ReadMemory(const GvcpCommand& command) const {
  const auto fail = [&](GvcpStatus status) { return FormatAcknowledge(command, status, {}); };
  if (command.payload.size() != 8) return fail(GvcpStatus::kInvalidParameter);
  const std::uint32_t address = ReadU32(command.payload, 0), count = ReadU32(command.payload, 4) & 0xFFFF;
  if (count == 0 || count > kGvcpMaxPayloadBytes - 4) return fail(GvcpStatus::kInvalidParameter);
  if (address % 4 != 0 || count % 4 != 0) return fail(GvcpStatus::kBadAlignment);
  const auto bytes = registers_.Read(address, count);
  if (!bytes) return fail(GvcpStatus::kInvalidAddress);
  std::vector<std::uint8_t> answer(command.payload.begin(), command.payload.begin() + 4);
  answer.insert(answer.end(), bytes->begin(), bytes->end());
  return FormatAcknowledge(command, GvcpStatus::kSuccess, answer);
}

std::vector<std::uint8_t> GigeCamera::WriteRegisters(const GvcpCommand& command, const sockaddr_in& peer) {
  std::array<std::uint8_t, 4> written{};
  if (command.payload.empty() || command.payload.size() % 8 != 0)
    return FormatAcknowledge(command, GvcpStatus::kInvalidParameter, written);
  for (std::size_t at = 0; at < command.payload.size(); at += 8) {
    const GvcpStatus status = Write(ReadU32(command.payload, at), command.payload.subspan(at + 4, 4), peer);
    if (status != GvcpStatus::kSuccess) return FormatAcknowledge(command, status, written);
    ++written[3];
  }
  return FormatAcknowledge(command, GvcpStatus::kSuccess, written);
}

std::vector<std::uint8_t> GigeCamera::WriteMemory(const GvcpCommand& command, const sockaddr_in& peer) {
  std::array<std::uint8_t, 4> written{};
  if (command.payload.size() <= 4) return FormatAcknowledge(command, GvcpStatus::kInvalidParameter, written);
  const auto bytes = command.payload.subspan(4);
  const GvcpStatus status = Write(ReadU32(command.payload, 0), bytes, peer);
  if (status == GvcpStatus::kSuccess) WriteU32(written, 0, static_cast<std::uint32_t>(bytes.size()));
  return FormatAcknowledge(command, status, written);
}

GvcpStatus GigeCamera::Write(std::uint32_t address, std::span<const std::uint8_t> bytes,
                             const sockaddr_in& peer) {
  const bool controlled = *registers_.ReadWord(kRegControl) != 0;
  if (controlled && !SamePeer(peer, controller_)) return GvcpStatus::kAccessDenied;
  if (!controlled && address != kRegControl) return GvcpStatus::kAccessDenied;
  const GvcpStatus status = registers_.Write(address, bytes);
  if (status != GvcpStatus::kSuccess) return status;
  if (address == kRegControl) {
    const bool taken = *registers_.ReadWord(kRegControl) != 0;
    controller_ = taken ? peer : sockaddr_in{};
    last_heard_ns_ = linux::MonotonicNs();
    if (!taken) acquiring_.store(false);
  }
  if (address == kRegAcquisition) acquiring_.store(*registers_.ReadWord(kRegAcquisition) != 0);
  if (address == kRegPtpEnable) {
    registers_.Set(kRegPtpStatus,
                   options_.has_ptp && *registers_.ReadWord(kRegPtpEnable) != 0 ? kPtpSlave : 0);
  }
  constexpr std::uint32_t kFireTestPacket = 0x80000000;
  const std::uint32_t packet_size = *registers_.ReadWord(kRegPacketSize);
  if (address == kRegPacketSize && (packet_size & kFireTestPacket) != 0) {
    registers_.Set(kRegPacketSize, packet_size & ~kFireTestPacket);
    SendTestPacket();
  }
  return status;
}

void GigeCamera::SendTestPacket() {
  const Target target = StreamTarget();
  const std::vector<std::uint8_t> packet(target.payload_bytes + kGvspHeaderBytes);
  sendto(stream_socket_.Get(), packet.data(), packet.size(), 0,
         reinterpret_cast<const sockaddr*>(&target.address), sizeof(target.address));
}

void GigeCamera::LetGoOfSilentController() {
  const std::lock_guard lock(mutex_);
  if (faults_.vanished.load()) {
    PowerOn();
    return;
  }
  const bool controlled = *registers_.ReadWord(kRegControl) != 0;
  const std::int64_t limit_ns = *registers_.ReadWord(kRegHeartbeatMs) * base::kNsPerMs;
  if (controlled && linux::MonotonicNs() - last_heard_ns_ > limit_ns) PowerOn();
}

void GigeCamera::PowerOn() {
  registers_ = GigeRegisters(options_.identity);
  controller_ = {};
  acquiring_.store(false);
  next_id_ = options_.first_frame_id;
  for (KeptFrame& frame : frames_) frame.trigger = kNoTrigger;  // the ids begin anew
}

GigeCamera::Target GigeCamera::StreamTarget() {
  Target target;
  target.address.sin_family = AF_INET;
  target.address.sin_addr.s_addr = htonl(*registers_.ReadWord(kRegStreamAddress));
  target.address.sin_port = htons(static_cast<std::uint16_t>(*registers_.ReadWord(kRegStreamPort)));
  constexpr std::size_t kOverhead = kIpUdpBytes + kGvspHeaderBytes,
                        kSmallest = 576;  // the standard's least packet
  const std::size_t packet_bytes =
      std::max<std::size_t>(*registers_.ReadWord(kRegPacketSize) & 0xFFFF, kSmallest);
  target.payload_bytes = packet_bytes - kOverhead;
  return target;
}

}  // namespace adit::sim
