// The box's own map behind the server, read as a PLC would: through libmodbus.
#include <modbus.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <memory>
#include <thread>
#include <vector>

#include "drivers/modbus/modbus_server.h"
#include "firmware/publish/crc16.h"
#include "firmware/publish/modbus_reply.h"

#include <CppUTest/TestHarness.h>

namespace adit::modbus {
namespace {

constexpr base::TimeNs kNowNs = 1'700'000'000 * base::kNsPerS;
constexpr int kUnit = 17;

class Box final : public hal::RequestHandler {
 public:
  Box() { Tell(1); }
  std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply) override {
    return responder_.Answer(request, reply, kNowNs);
  }
  // Every value of epoch n is made of n, so that a mixture of two epochs shows.
  void Tell(std::uint16_t number) {
    publish::BoxCondition box{
        .epoch = number, .heartbeat = number, .initialised = true, .georeferenced = true};
    georef::GeoFix fix;
    fix.state.points.status = stereo::FixStatus::kTracked;
    fix.state.mid_exposure_ns = kNowNs;
    fix.position_s_m = Eigen::Vector3d(number, number, number);
    map_.Update(publish::MakeEpoch(&fix, box, {}, kNowNs), box, {}, {}, kNowNs);
  }

 private:
  publish::RegisterMap map_{publish::MakeIdentity("4711", "1.2.3", 0xABCD), {}};
  publish::ModbusResponder responder_{map_, kUnit};
};

struct Closer {
  void operator()(modbus_t* client) const {
    modbus_close(client);
    modbus_free(client);
  }
};
using Client = std::unique_ptr<modbus_t, Closer>;

bool LiveBlockIsWhole(const std::array<std::uint16_t, 42>& live) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < live.size(); ++i) {
    bytes.push_back(static_cast<std::uint8_t>(live[i] >> 8));
    bytes.push_back(static_cast<std::uint8_t>(live[i] & 0xFF));
  }
  bytes.push_back(0xFF);
  bytes.push_back(0xA0);
  const unsigned east = live[4] * 65536U + live[5];
  return publish::Crc16(bytes) == live[41] && live[0] == live[40] && live[38] == live[0] &&
         east == live[0] * 10'000U;
}

}  // namespace

TEST_GROUP(LibmodbusClient) {
  Box box_;
  std::unique_ptr<ModbusServer> server_;

  void setup() override {
    ServerOptions options;
    options.bind = "127.0.0.1";
    options.port = 0;
    server_ = *ModbusServer::Open(options, box_);
  }
  void teardown() override { server_.reset(); }

  Client Connect(int unit = kUnit) const {
    Client client(modbus_new_tcp("127.0.0.1", server_->Port()));
    modbus_set_slave(client.get(), unit);
    LONGS_EQUAL(0, modbus_connect(client.get()));
    return client;
  }
};

TEST(LibmodbusClient, ReadsInputAndHoldingRegisters) {
  const Client client = Connect();
  std::array<std::uint16_t, 9> input{}, holding{};
  LONGS_EQUAL(9, modbus_read_input_registers(client.get(), 0, 9, input.data()));
  LONGS_EQUAL(9, modbus_read_registers(client.get(), 0, 9, holding.data()));
  CHECK(input == holding);
  LONGS_EQUAL(0x4144, input[0]);
  LONGS_EQUAL(0x1234, input[4]);
  LONGS_EQUAL(0x5678, input[5]);
  DOUBLES_EQUAL(123.456F, modbus_get_float_abcd(&input[6]), 0);
}

TEST(LibmodbusClient, ReadsDiscreteInputs) {
  const Client client = Connect();
  std::array<std::uint8_t, 16> bits{};
  LONGS_EQUAL(16, modbus_read_input_bits(client.get(), 0, 16, bits.data()));
  LONGS_EQUAL(1, bits[0]);
  LONGS_EQUAL(1, bits[1]);
  LONGS_EQUAL(0, bits[2]);
  LONGS_EQUAL(1, bits[12]);
}

TEST(LibmodbusClient, IdentifiesTheBox) {
  const Client client = Connect();
  std::array<std::uint8_t, 5> request{kUnit, 0x2B, 0x0E, 4, 2};
  LONGS_EQUAL(12,
              modbus_send_raw_request(client.get(), request.data(), static_cast<int>(request.size())) + 1);
  // libmodbus' client knows no answer to this function, so the bytes are taken from its socket.
  std::array<std::uint8_t, 64> reply{};
  std::size_t got = 0;
  while (got < 21) {
    pollfd waiting{modbus_get_socket(client.get()), POLLIN, 0};
    LONGS_EQUAL(1, ::poll(&waiting, 1, 2000));
    const ssize_t count = ::recv(modbus_get_socket(client.get()), reply.data() + got, reply.size() - got, 0);
    CHECK(count > 0);
    got += static_cast<std::size_t>(count);
  }
  const std::array<std::uint8_t, 13> tail{0x0E, 4, 0x83, 0, 0, 1, 2, 5, '1', '.', '2', '.', '3'};
  CHECK(std::equal(tail.begin(), tail.end(), reply.begin() + 8));
}

TEST(LibmodbusClient, SeesTheExceptions) {
  const Client client = Connect();
  std::array<std::uint16_t, 2> words{};
  LONGS_EQUAL(-1, modbus_read_input_registers(client.get(), 9, 1, words.data()));
  LONGS_EQUAL(EMBXILADD, errno);
  LONGS_EQUAL(-1, modbus_write_register(client.get(), 2000, 0xA717));
  LONGS_EQUAL(EMBXILFUN, errno);
  LONGS_EQUAL(-1, modbus_write_registers(client.get(), 2000, 2, words.data()));
  LONGS_EQUAL(EMBXILFUN, errno);
  LONGS_EQUAL(-1, modbus_write_and_read_registers(client.get(), 2000, 1, words.data(), 0, 1, words.data()));
  LONGS_EQUAL(EMBXILFUN, errno);
  const Client stranger = Connect(18);
  LONGS_EQUAL(-1, modbus_read_input_registers(stranger.get(), 0, 1, words.data()));
  LONGS_EQUAL(EMBXGTAR, errno);
}

TEST(LibmodbusClient, EveryReadOfSeveralClientsIsOneEpoch) {
  constexpr int kClients = 4, kReads = 500;
  std::atomic<int> whole{0};
  std::atomic<bool> done{false};
  std::thread publisher([&] {
    for (std::uint16_t number = 0; !done.load(); ++number) box_.Tell(number % 20'000);
  });
  std::vector<std::thread> readers;
  for (int i = 0; i < kClients; ++i) {
    readers.emplace_back([&] {
      const Client client = Connect();
      std::array<std::uint16_t, 42> live{};
      for (int read = 0; read < kReads; ++read) {
        const bool got = modbus_read_input_registers(client.get(), 100, 42, live.data()) == 42;
        if (got && LiveBlockIsWhole(live)) whole.fetch_add(1);
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
  done.store(true);
  publisher.join();
  LONGS_EQUAL(kClients * kReads, whole.load());
}

}  // namespace adit::modbus
