#include "firmware/publish/e2e.h"

#include <array>
#include <string_view>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

std::vector<std::uint8_t> Bytes(std::string_view hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

struct CrcVector {
  std::string_view message;
  std::uint16_t crc;
};

// AUTOSAR SWS CRCLibrary, table of results of CRC16 CCITT-FALSE.
constexpr CrcVector kAutosar[] = {
    {"00000000", 0x84C0},           {"F20183", 0xD374}, {"0FAA0055", 0x2023}, {"00FF5511", 0xB8F9},
    {"332255AABBCCDDEEFF", 0xF53F}, {"926B55", 0x0745}, {"FFFFFFFF", 0x1D0F}};

// The golden set's first frame: node 0x20, POS_E.
constexpr Payload kGolden{0x87, 0xC9, 0xEE, 0xF6, 0x4D, 0x17, 0x49, 0xFA};
constexpr std::uint16_t kGoldenId = 0xA200;

}  // namespace

TEST_GROUP(E2e){};

TEST(E2e, CrcGivesTheResultsOfAutosarsTable) {
  for (const CrcVector& vector : kAutosar) {
    const auto bytes = Bytes(vector.message);
    LONGS_EQUAL(vector.crc, Crc16(bytes));
  }
}

TEST(E2e, CrcOfTheDigitsIsTheCatalogueValue) {
  const auto bytes = Bytes("313233343536373839");
  LONGS_EQUAL(0x29B1, Crc16(bytes));
}

TEST(E2e, CrcGoesOnWhereItStopped) {
  const auto bytes = Bytes("332255AABBCCDDEEFF");
  const std::span<const std::uint8_t> all(bytes);
  LONGS_EQUAL(0xF53F, Crc16(all.subspan(4), Crc16(all.first(4))));
}

// AUTOSAR PRS E2EProtocol, profile 5 examples, data id 0x1234: offsets 0 and 64 bit. They fix what is
// covered, and that the data id comes last, low byte first.
TEST(E2e, CrcOverDataAndIdGivesAutosarsProfile5Frames) {
  LONGS_EQUAL(0xCA1C, Crc16(Bytes("0000000000003412")));
  LONGS_EQUAL(0x8DCF, Crc16(Bytes("0100000000003412")));
  LONGS_EQUAL(0x9128, Crc16(Bytes("00000000000000000000000000003412")));
}

TEST(E2e, DataIdHoldsAddressAndSlot) {
  LONGS_EQUAL(0xA200, DataId(0x20, 0));
  LONGS_EQUAL(0xA20E, DataId(0x20, 14));
  LONGS_EQUAL(0xA7E8, DataId(0x7E, 8));
}

TEST(E2e, ProtectsTheGoldenFrameAsItStands) {
  Payload payload = kGolden;
  payload[5] = payload[6] = payload[7] = 0;
  Protect(payload, kGoldenId, 250);
  CHECK(payload == kGolden);
}

TEST(E2e, FindsEveryOneTwoAndThreeBitError) {
  CHECK(Check(kGolden, kGoldenId));
  const auto flipped = [](Payload payload, unsigned bit) {
    payload[bit / 8] = static_cast<std::uint8_t>(payload[bit / 8] ^ (1U << (bit % 8)));
    return payload;
  };
  unsigned missed = 0;
  for (unsigned a = 0; a < 64; ++a) {
    const Payload one = flipped(kGolden, a);
    missed += Check(one, kGoldenId);
    for (unsigned b = a + 1; b < 64; ++b) {
      const Payload two = flipped(one, b);
      missed += Check(two, kGoldenId);
      for (unsigned c = b + 1; c < 64; ++c) missed += Check(flipped(two, c), kGoldenId);
    }
  }
  LONGS_EQUAL(0, missed);
}

TEST(E2e, AFrameOfAnotherBoxOrSlotDoesNotPass) {
  for (unsigned address = 0; address < 128; ++address) {
    for (unsigned slot = 0; slot < 16; ++slot) {
      const std::uint16_t id = DataId(static_cast<std::uint8_t>(address), static_cast<std::uint8_t>(slot));
      CHECK_EQUAL(id == kGoldenId, Check(kGolden, id));
    }
  }
}

}  // namespace adit::publish
