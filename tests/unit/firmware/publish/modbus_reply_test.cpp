#include "firmware/publish/modbus_reply.h"

#include <array>
#include <random>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/publish/fixes.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

using Message = std::vector<std::uint8_t>;
constexpr std::uint8_t kUnit = 17;

}  // namespace

TEST_GROUP(ModbusReply) {
  RegisterMap map_{MakeIdentity("4711", "1.2.3", 0), {}};
  ModbusResponder responder_{map_, kUnit};
  base::TimeNs now_ns_ = kExposureNs;

  Message Ask(const Message& request) const {
    Message reply(kMaxModbusMessage);
    reply.resize(responder_.Answer(request, reply, now_ns_));
    return reply;
  }
  // Function and exception code; 0 if the answer is none.
  int ExceptionOf(const Message& request) const {
    const Message reply = Ask(request);
    return reply.size() == 3 && reply[0] == request[0] && reply[1] == (request[1] | 0x80) ? reply[2] : 0;
  }
  static Message Read(unsigned function, unsigned first, unsigned count, unsigned unit = kUnit) {
    Message request;
    for (const unsigned byte : {unit, function, first >> 8, first, count >> 8, count}) {
      request.push_back(static_cast<std::uint8_t>(byte & 0xFF));
    }
    return request;
  }
};

TEST(ModbusReply, ReadsInputAndHoldingRegistersAlike) {
  const Message input{kUnit, 4,    18,   0x41, 0x44, 0x49, 0x54, 1,    0,    0,   42,
                      0x12,  0x34, 0x56, 0x78, 0x42, 0xF6, 0xE9, 0x79, 0xFF, 0xFE};
  CHECK(Ask(Read(4, 0, 9)) == input);
  Message holding = input;
  holding[1] = 3;
  CHECK(Ask(Read(3, 0, 9)) == holding);
}

TEST(ModbusReply, ReadsTheLargestCount) {
  const Message reply = Ask(Read(4, 1000, 125));
  LONGS_EQUAL(3 + 250, reply.size());
  LONGS_EQUAL(250, reply[2]);
}

TEST(ModbusReply, ReadsDiscreteInputsPackedFromTheLowestBit) {
  map_.Update(MakeEpoch(nullptr, GoodBox(), {}, now_ns_), GoodBox(), {}, {}, now_ns_);
  // alive 0, cameras 5 6, radio 7, CAN 8, time sync 9, PLC 10, georeference 12
  CHECK((Ask(Read(2, 0, 16)) == Message{kUnit, 2, 2, 0xE1, 0x17}));
  CHECK((Ask(Read(2, 5, 5)) == Message{kUnit, 2, 1, 0x1F}));
  CHECK((Ask(Read(2, 15, 1)) == Message{kUnit, 2, 1, 0}));
}

TEST(ModbusReply, AnswersItsOwnUnit0And255) {
  for (const unsigned unit : {unsigned{kUnit}, 0U, 255U}) {
    const Message reply = Ask(Read(4, 0, 1, unit));
    LONGS_EQUAL(5, reply.size());
    LONGS_EQUAL(unit, reply[0]);
  }
  LONGS_EQUAL(0x0B, ExceptionOf(Read(4, 0, 1, 18)));
  LONGS_EQUAL(0x0B, ExceptionOf(Read(99, 0, 1, 18)));
}

TEST(ModbusReply, WritesAreOff) {
  LONGS_EQUAL(1, ExceptionOf({kUnit, 6, 0x07, 0xD0, 0xA7, 0x17}));
  LONGS_EQUAL(1, ExceptionOf({kUnit, 16, 0x07, 0xD0, 0, 1, 2, 0xA7, 0x17}));
  LONGS_EQUAL(1, ExceptionOf({kUnit, 23, 0, 0, 0, 1, 0x07, 0xD0, 0, 1, 2, 0xA7, 0x17}));
  LONGS_EQUAL(1, ExceptionOf({kUnit, 5, 0, 0, 0xFF, 0}));
}

TEST(ModbusReply, EveryFunctionThatIsNotServedIsRefused) {
  for (unsigned function = 0; function < 128; ++function) {
    if (function == 2 || function == 3 || function == 4 || function == 0x2B) continue;
    LONGS_EQUAL(1, ExceptionOf(Read(function, 0, 1)));
  }
}

TEST(ModbusReply, CountIsJudgedBeforeAddress) {
  for (const unsigned function : {3U, 4U}) {
    LONGS_EQUAL(3, ExceptionOf(Read(function, 50'000, 0)));
    LONGS_EQUAL(3, ExceptionOf(Read(function, 50'000, 126)));
    LONGS_EQUAL(2, ExceptionOf(Read(function, 50'000, 125)));
  }
  LONGS_EQUAL(3, ExceptionOf(Read(2, 50'000, 0)));
  LONGS_EQUAL(3, ExceptionOf(Read(2, 50'000, 2001)));
  LONGS_EQUAL(2, ExceptionOf(Read(2, 0, 2000)));
}

TEST(ModbusReply, AddressesBesideTheMapAreRefused) {
  LONGS_EQUAL(2, ExceptionOf(Read(4, 8, 2)));
  LONGS_EQUAL(2, ExceptionOf(Read(4, 9, 1)));
  LONGS_EQUAL(2, ExceptionOf(Read(4, 99, 43)));
  LONGS_EQUAL(2, ExceptionOf(Read(4, 1639, 2)));
  LONGS_EQUAL(2, ExceptionOf(Read(4, 65535, 1)));
  LONGS_EQUAL(2, ExceptionOf(Read(4, 65535, 125)));
  LONGS_EQUAL(2, ExceptionOf(Read(2, 16, 1)));
  LONGS_EQUAL(2, ExceptionOf(Read(2, 65535, 2)));
}

TEST(ModbusReply, AWrongLengthIsAnIllegalValue) {
  Message request = Read(4, 0, 1);
  request.pop_back();
  LONGS_EQUAL(3, ExceptionOf(request));
  request = Read(4, 0, 1);
  request.push_back(0);
  LONGS_EQUAL(3, ExceptionOf(request));
  LONGS_EQUAL(3, ExceptionOf({kUnit, 2}));
  LONGS_EQUAL(3, ExceptionOf({kUnit, 0x2B, 0x0E}));
}

TEST(ModbusReply, LessThanAFunctionCodeIsMetWithSilence) {
  LONGS_EQUAL(0, Ask({}).size());
  LONGS_EQUAL(0, Ask({kUnit}).size());
}

TEST(ModbusReply, AReplyWithoutRoomIsNotBegun) {
  Message small(kMaxModbusMessage - 1);
  LONGS_EQUAL(0, responder_.Answer(Read(4, 0, 1), small, now_ns_));
}

// Modbus Application Protocol V1.1b3, 6.21.
TEST(ModbusReply, IdentifiesTheBoxAsBasicStream) {
  Message expected{kUnit, 0x2B, 0x0E, 1, 0x83, 0, 0, 3};
  const auto add = [&](std::uint8_t id, const std::string& text) {
    expected.push_back(id);
    expected.push_back(static_cast<std::uint8_t>(text.size()));
    expected.insert(expected.end(), text.begin(), text.end());
  };
  add(0, "adit");
  add(1, "ADIT");
  add(2, "1.2.3");
  CHECK(Ask({kUnit, 0x2B, 0x0E, 1, 0}) == expected);
  // An object that is not of the category starts the stream anew.
  CHECK(Ask({kUnit, 0x2B, 0x0E, 1, 0x80}) == expected);
}

TEST(ModbusReply, IdentifiesFromTheObjectAskedFor) {
  const Message regular = Ask({kUnit, 0x2B, 0x0E, 2, 2});
  LONGS_EQUAL(2, regular[7]);
  LONGS_EQUAL(2, regular[8]);
  const Message extended = Ask({kUnit, 0x2B, 0x0E, 3, 0});
  LONGS_EQUAL(5, extended[7]);
}

TEST(ModbusReply, IdentifiesOneObject) {
  const Message serial{kUnit, 0x2B, 0x0E, 4, 0x83, 0, 0, 1, 0x80, 4, '4', '7', '1', '1'};
  CHECK(Ask({kUnit, 0x2B, 0x0E, 4, 0x80}) == serial);
  LONGS_EQUAL(2, ExceptionOf({kUnit, 0x2B, 0x0E, 4, 0x33}));
}

TEST(ModbusReply, RefusesOtherEncapsulationsAndCategories) {
  LONGS_EQUAL(1, ExceptionOf({kUnit, 0x2B, 0x0D, 1, 0}));
  LONGS_EQUAL(3, ExceptionOf({kUnit, 0x2B, 0x0E, 0, 0}));
  LONGS_EQUAL(3, ExceptionOf({kUnit, 0x2B, 0x0E, 5, 0}));
}

TEST(ModbusReply, RandomBytesGetAnAnswerOfTheirFunctionOrAnException) {
  std::mt19937 random(20'260'101);
  std::uniform_int_distribution<int> byte(0, 255), length(2, 254), unit(0, 2), function(0, 9);
  constexpr std::uint8_t kUnits[] = {kUnit, 0, 255};
  for (int i = 0; i < 20'000; ++i) {
    Message request(static_cast<std::size_t>(i % 2 == 0 ? length(random) : 6));
    for (std::uint8_t& b : request) b = static_cast<std::uint8_t>(byte(random));
    request[0] = kUnits[unit(random)];
    if (function(random) > 2) request[1] = static_cast<std::uint8_t>(2 + i % 3);
    const Message reply = Ask(request);
    CHECK(reply.size() >= 3 && reply.size() <= kMaxModbusMessage);
    LONGS_EQUAL(request[0], reply[0]);
    LONGS_EQUAL(request[1] & 0x7F, reply[1] & 0x7F);
  }
}

TEST(ModbusReply, AllocatesNothing) {
  const Message request = Read(4, 100, 42);
  std::array<std::uint8_t, kMaxModbusMessage> reply;
  const std::uint64_t before = support::AllocationCount();
  const std::size_t length = responder_.Answer(request, reply, now_ns_);
  LONGS_EQUAL(0, support::AllocationCount() - before);
  LONGS_EQUAL(3 + 84, length);
}

}  // namespace adit::publish
