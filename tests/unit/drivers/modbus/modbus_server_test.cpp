// The server's door, with a handler that echoes its request: what comes back shows what was framed.
#include "drivers/modbus/modbus_server.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "tests/unit/drivers/modbus/plain_client.h"

#include <CppUTest/TestHarness.h>

namespace adit::modbus {
namespace {

using std::chrono::milliseconds;

class Echo final : public hal::RequestHandler {
 public:
  std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply) override {
    if (request[1] == kSilent) return 0;
    std::ranges::copy(request, reply.begin());
    return request[1] == kLong ? reply.size() : request.size();
  }
  static constexpr std::uint8_t kSilent = 99;
  static constexpr std::uint8_t kLong = 98;
};

Bytes Request(std::uint8_t transaction, std::uint8_t function = 4, std::size_t data = 4) {
  const Bytes header{0x77, transaction, 0, 0, 0, static_cast<std::uint8_t>(2 + data), 1, function};
  Bytes bytes(header.size() + data, transaction);
  std::ranges::copy(header, bytes.begin());
  return bytes;
}

}  // namespace

TEST_GROUP(ModbusServer) {
  Echo echo_;
  std::unique_ptr<ModbusServer> server_;

  void Open(ServerOptions options = {}) {
    options.bind = "127.0.0.1";
    options.port = 0;
    auto opened = ModbusServer::Open(options, echo_);
    CHECK(static_cast<bool>(opened));
    server_ = std::move(*opened);
  }
  std::uint16_t Port() const { return server_->Port(); }
  void teardown() override { server_.reset(); }

  // Waits for what another thread is about to do; a second is far more than it takes.
  template <class Condition>
  static bool Soon(Condition condition) {
    for (int i = 0; i < 1000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return condition();
  }
};

TEST(ModbusServer, AnswersAndKeepsTheTransaction) {
  Open();
  PlainClient client(Port());
  CHECK(client.Send(Request(5)));
  CHECK(client.Receive(12) == Request(5));
  CHECK(Soon([&] { return server_->Health().requests == 1; }));
}

TEST(ModbusServer, AnswersRequestsSentWithoutWaitingInTheirOrder) {
  Open();
  PlainClient client(Port());
  Bytes all;
  for (int i = 0; i < 200; ++i) {
    const Bytes request = Request(static_cast<std::uint8_t>(i), 4, static_cast<std::size_t>(i));
    all.insert(all.end(), request.begin(), request.end());
  }
  CHECK(client.Send(all));
  CHECK(client.Receive(all.size()) == all);
}

TEST(ModbusServer, AnswersTheLongestRequest) {
  Open();
  PlainClient client(Port());
  const Bytes longest = Request(1, 4, 252);
  for (int i = 0; i < 20; ++i) CHECK(client.Send(longest));
  Bytes all = client.Receive(20 * longest.size());
  LONGS_EQUAL(20 * longest.size(), all.size());
}

TEST(ModbusServer, ManyShortRequestsForLongAnswersAreAllAnswered) {
  Open();
  PlainClient client(Port());
  Bytes all;
  for (int i = 0; i < 500; ++i) {
    const Bytes request = Request(static_cast<std::uint8_t>(i), Echo::kLong);
    all.insert(all.end(), request.begin(), request.end());
  }
  CHECK(client.Send(all));
  constexpr std::size_t kAnswer = 6 + 254;
  const Bytes answers = client.Receive(500 * kAnswer);
  LONGS_EQUAL(500 * kAnswer, answers.size());
  for (std::size_t i = 0; i < 500; ++i) LONGS_EQUAL(i % 256, answers[i * kAnswer + 1]);
}

TEST(ModbusServer, AnswersWhatCameBeforeTheClientEndedItsSide) {
  Open();
  PlainClient client(Port());
  CHECK(client.Send(Request(1)));
  CHECK(client.Send(Request(2)));
  client.EndSending();
  LONGS_EQUAL(24, client.Receive(25).size());
  CHECK(client.IsClosed());
}

TEST(ModbusServer, SilenceOfTheHandlerKeepsTheConnection) {
  Open();
  PlainClient client(Port());
  CHECK(client.Send(Request(1, Echo::kSilent)));
  CHECK(client.Send(Request(2)));
  CHECK(client.Receive(12) == Request(2));
}

TEST(ModbusServer, ARequestInPiecesIsOneRequest) {
  Open();
  PlainClient client(Port());
  for (const std::uint8_t byte : Request(9)) {
    CHECK(client.Send({byte}));
    std::this_thread::sleep_for(milliseconds(2));
  }
  CHECK(client.Receive(12) == Request(9));
}

TEST(ModbusServer, ClosesOnAWrongProtocolId) {
  Open();
  PlainClient client(Port());
  CHECK(client.Send({0, 1, 0, 1, 0, 6, 1, 4, 0, 0, 0, 1}));
  CHECK(client.IsClosed());
  LONGS_EQUAL(1, server_->Health().malformed);
}

TEST(ModbusServer, ClosesOnALengthThatNoRequestHas) {
  Open();
  for (const int length : {0, 1, 255, 65535}) {
    PlainClient client(Port());
    CHECK(client.Send({0, 1, 0, 0, static_cast<std::uint8_t>(length >> 8),
                       static_cast<std::uint8_t>(length & 0xFF), 1, 4}));
    CHECK(client.IsClosed());
  }
  LONGS_EQUAL(4, server_->Health().malformed);
}

TEST(ModbusServer, AWebBrowserIsShownTheDoorAndOthersStillServed) {
  Open();
  PlainClient browser(Port());
  const std::string words = "GET / HTTP/1.1\r\n\r\n";
  CHECK(browser.Send(Bytes(words.begin(), words.end())));
  CHECK(browser.IsClosed());
  PlainClient client(Port());
  CHECK(client.Send(Request(1)));
  CHECK(client.Receive(12) == Request(1));
}

TEST(ModbusServer, HalfAFrameIsGivenUpAfterItsLimit) {
  ServerOptions options;
  options.partial_limit_ns = 100 * base::kNsPerMs;
  Open(options);
  PlainClient client(Port());
  CHECK(client.Send(Request(1)));
  CHECK(client.Receive(12) == Request(1));
  CHECK(client.Send({0, 1, 0, 0, 0, 6, 1}));
  CHECK_FALSE(client.IsClosed(50));
  CHECK(client.IsClosed());
  LONGS_EQUAL(1, server_->Health().timed_out);
}

TEST(ModbusServer, DrippingDoesNotProlongTheLimit) {
  ServerOptions options;
  options.partial_limit_ns = 100 * base::kNsPerMs;
  Open(options);
  PlainClient client(Port());
  // A request of 254 bytes was promised: each byte that drips in may belong to it.
  CHECK(client.Send({0, 1, 0, 0, 0, 254}));
  bool closed = false;
  for (int i = 0; i < 60 && !closed; ++i) {
    (void)client.Send({0});
    closed = client.IsClosed(10);
  }
  CHECK(closed);
  LONGS_EQUAL(1, server_->Health().timed_out);
}

TEST(ModbusServer, AnIdleClientIsClosed) {
  ServerOptions options;
  options.idle_limit_ns = 100 * base::kNsPerMs;
  Open(options);
  PlainClient client(Port());
  CHECK(client.IsClosed());
  LONGS_EQUAL(1, server_->Health().timed_out);
}

TEST(ModbusServer, ADrippingClientDoesNotHoldUpAnother) {
  Open();
  PlainClient dripping(Port());
  CHECK(dripping.Send({0, 1, 0, 0, 0, 6, 1}));
  PlainClient brisk(Port());
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 50; ++i) {
    CHECK(brisk.Send(Request(1)));
    LONGS_EQUAL(12, brisk.Receive(12).size());
  }
  // libmodbus' server takes seconds here.
  CHECK(std::chrono::steady_clock::now() - start < milliseconds(500));
}

TEST(ModbusServer, AClientThatDoesNotReadItsAnswersHoldsUpNobody) {
  Open();
  PlainClient deaf(Port(), "127.0.0.1", 4096);
  Bytes flood;
  for (int i = 0; i < 1000; ++i) {
    const Bytes request = Request(1, 4, 252);
    flood.insert(flood.end(), request.begin(), request.end());
  }
  // Until the server takes no more of it: then its answers are stuck.
  int refused_in_a_row = 0;
  for (int i = 0; i < 5000 && refused_in_a_row < 50; ++i) {
    refused_in_a_row = deaf.SendWithoutWaiting(flood) == 0 ? refused_in_a_row + 1 : 0;
    if (refused_in_a_row > 0) std::this_thread::sleep_for(milliseconds(1));
  }
  LONGS_EQUAL(50, refused_in_a_row);
  PlainClient other(Port());
  CHECK(other.Send(Request(7)));
  CHECK(other.Receive(12, 500) == Request(7));
}

TEST(ModbusServer, OnePeerGetsEightConnections) {
  Open();
  std::vector<std::unique_ptr<PlainClient>> clients;
  for (int i = 0; i < 8; ++i) clients.push_back(std::make_unique<PlainClient>(Port()));
  CHECK(Soon([&] { return server_->Health().clients == 8; }));
  PlainClient ninth(Port());
  CHECK(ninth.IsClosed());
  LONGS_EQUAL(1, server_->Health().refused);
  PlainClient neighbour(Port(), "127.0.0.2");
  CHECK(neighbour.Send(Request(1)));
  LONGS_EQUAL(12, neighbour.Receive(12).size());
  clients.pop_back();
  CHECK(Soon([&] { return server_->Health().clients == 8; }));
  PlainClient again(Port());
  CHECK(again.Send(Request(1)));
  LONGS_EQUAL(12, again.Receive(12).size());
}

TEST(ModbusServer, ListedPeersGetInWhenItIsFull) {
  ServerOptions options;
  options.connections_max = 3;
  options.admitted = {"127.0.0.9"};
  Open(options);
  PlainClient oldest(Port(), "127.0.0.2");
  CHECK(Soon([&] { return server_->Health().clients == 1; }));
  PlainClient second(Port(), "127.0.0.3"), third(Port(), "127.0.0.4");
  CHECK(Soon([&] { return server_->Health().clients == 3; }));
  PlainClient stranger(Port(), "127.0.0.5");
  CHECK(stranger.IsClosed());
  PlainClient listed(Port(), "127.0.0.9");
  CHECK(listed.Send(Request(1)));
  LONGS_EQUAL(12, listed.Receive(12).size());
  CHECK(oldest.IsClosed());
  LONGS_EQUAL(3, server_->Health().clients);
}

TEST(ModbusServer, ClosingItClosesItsClients) {
  Open();
  PlainClient client(Port());
  CHECK(client.Send(Request(1)));
  LONGS_EQUAL(12, client.Receive(12).size());
  const auto start = std::chrono::steady_clock::now();
  server_.reset();
  CHECK(std::chrono::steady_clock::now() - start < milliseconds(90));
  CHECK(client.IsClosed(0));
}

TEST(ModbusServer, APortInUseIsOneLine) {
  Open();
  ServerOptions options;
  options.bind = "127.0.0.1";
  options.port = Port();
  auto second = ModbusServer::Open(options, echo_);
  CHECK_FALSE(static_cast<bool>(second));
  const std::string expected =
      "modbus 127.0.0.1:" + std::to_string(Port()) + ": cannot listen: Address already in use";
  STRCMP_EQUAL(expected.c_str(), second.error().Line().c_str());
  LONGS_EQUAL(1, second.error().ExitCode());
}

TEST(ModbusServer, AnAddressThatIsNoneIsRefused) {
  ServerOptions options;
  options.bind = "localhost";
  STRCMP_CONTAINS("is not an IPv4 address", ModbusServer::Open(options, echo_).error().Line().c_str());
  options.bind = "127.0.0.1";
  options.port = 0;
  options.admitted = {"10.0.0.1", "plc"};
  STRCMP_CONTAINS("admitted \"plc\"", ModbusServer::Open(options, echo_).error().Line().c_str());
}

TEST(ModbusServer, APortIsFreeAgainAfterTheServerEnds) {
  Open();
  const std::uint16_t port = Port();
  {
    PlainClient client(port);
    CHECK(client.Send(Request(1)));
    LONGS_EQUAL(12, client.Receive(12).size());
    server_.reset();
  }
  ServerOptions options;
  options.bind = "127.0.0.1";
  options.port = port;
  CHECK(static_cast<bool>(ModbusServer::Open(options, echo_)));
}

}  // namespace adit::modbus
