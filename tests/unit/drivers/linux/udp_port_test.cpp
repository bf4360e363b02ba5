#include "drivers/linux/udp_port.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <array>

#include <CppUTest/TestHarness.h>

using adit::linux::UdpPort;

TEST_GROUP(UdpPort){};

TEST(UdpPort, ReachesItsReceiver) {
  const adit::linux::FileDescriptor receiver(socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  LONGS_EQUAL(0, bind(receiver.Get(), reinterpret_cast<sockaddr*>(&own), sizeof own));
  socklen_t length = sizeof own;
  LONGS_EQUAL(0, getsockname(receiver.Get(), reinterpret_cast<sockaddr*>(&own), &length));
  auto port = UdpPort::Open("127.0.0.1", ntohs(own.sin_port));
  CHECK(!!port);
  const std::array<char, 4> sent{'f', 'r', ' ', '1'};
  (*port)->Send(sent);
  std::array<char, 16> got{};
  LONGS_EQUAL(4, recv(receiver.Get(), got.data(), got.size(), 0));
  STRCMP_EQUAL("fr 1", got.data());
}

TEST(UdpPort, DeclinesWhatIsNoAddressByNamingIt) {
  const auto port = UdpPort::Open("tracker.example", 5000);
  CHECK(!port);
  STRCMP_CONTAINS("tracker.example:5000", port.error().Line().c_str());
}
