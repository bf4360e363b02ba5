// Arbitrary control packets to the simulated camera: what it answers, and that it still stands.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/sim/gige_camera.h"
#include "drivers/sim/gige_protocol.h"
#include "firmware/base/require.h"

namespace {

using adit::sim::GigeCamera;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kHeaderBytes = 8;
constexpr std::size_t kReplyMaxBytes = 548;  // 576 bytes with the headers of IP and UDP
constexpr std::size_t kDiscoveryBytes = 0xF8;

sockaddr_in Peer(std::uint16_t port) {
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = port;
  return peer;
}

std::uint32_t U16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 8 | bytes[at + 1];
}

// Nothing, or an acknowledge of exactly this command that says how long it is.
void Ask(GigeCamera& camera, std::span<const std::uint8_t> packet, std::uint16_t port) {
  const Bytes reply = camera.Reply(packet, Peer(port));
  const bool whole =
      packet.size() >= kHeaderBytes && packet[0] == 0x42 && U16(packet, 4) + kHeaderBytes == packet.size();
  if (!whole || (packet[1] & 1) == 0) ADIT_REQUIRE(reply.empty());
  if (reply.empty()) return;
  ADIT_REQUIRE(reply.size() >= kHeaderBytes && reply.size() <= kReplyMaxBytes);
  ADIT_REQUIRE(U16(reply, 2) == ((U16(packet, 2) + 1) & 0xFFFF));
  ADIT_REQUIRE(U16(reply, 4) + kHeaderBytes == reply.size());
  ADIT_REQUIRE(U16(reply, 6) == U16(packet, 6));
  const std::uint32_t status = U16(reply, 0);
  ADIT_REQUIRE(status == 0 || (status >= 0x8001 && status <= 0x8006));
}

// A header as an application writes it; which command, and mostly an address that exists, the bytes say.
void Repair(std::span<std::uint8_t> packet) {
  constexpr std::uint8_t kCommands[] = {0x02, 0x40, 0x80, 0x82, 0x84, 0x86, 0x82, 0x86};
  packet[0] = 0x42;
  packet[2] = 0;
  packet[3] = kCommands[packet[3] % sizeof kCommands];
  packet[4] = static_cast<std::uint8_t>((packet.size() - kHeaderBytes) >> 8);
  packet[5] = static_cast<std::uint8_t>(packet.size() - kHeaderBytes);
  if (packet.size() < kHeaderBytes + 4) return;
  packet[8] = 0;
  packet[9] &= 3;
}

// What identifies the camera is nobody's to change.
void CheckIdentity(GigeCamera& camera, const Bytes& before) {
  const Bytes discover{0x42, 1, 0, 2, 0, 0, 0, 1};
  ADIT_REQUIRE(camera.Reply(discover, Peer(3)) == before);
  ADIT_REQUIRE(before.size() == kHeaderBytes + kDiscoveryBytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  adit::sim::GigeOptions options;
  options.frame_bytes = 64;
  GigeCamera camera(options, [](std::uint64_t, std::uint8_t*) {});
  const Bytes before = camera.Reply(Bytes{0x42, 1, 0, 2, 0, 0, 0, 1}, Peer(3));
  Ask(camera, {data, size}, 1);
  // Control, so that writes are heard; then packets of one of two peers: each begins with its length and how
  // it is meant.
  Ask(camera, Bytes{0x42, 1, 0, 0x82, 0, 8, 0, 2, 0, 0, 0x0A, 0, 0, 0, 0, 2}, 1);
  for (std::size_t at = 0; at + 2 <= size;) {
    const std::size_t length = std::min<std::size_t>(data[at] % 48, size - at - 2);
    Bytes packet(data + at + 2, data + at + 2 + length);
    if ((data[at + 1] & 0x30) != 0 && packet.size() >= kHeaderBytes) Repair(packet);
    Ask(camera, packet, (data[at + 1] & 0x0F) == 0 ? 2 : 1);
    at += 2 + length;
  }
  CheckIdentity(camera, before);
  return 0;
}
