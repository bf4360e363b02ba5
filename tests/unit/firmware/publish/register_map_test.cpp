// Addresses and values stand here by hand, from the description of Modbus map 1.0; not from the table under
// test.
#include "firmware/publish/register_map.h"

#include <bit>
#include <cmath>
#include <string>

#include "firmware/publish/signal_table.h"
#include "tests/support/allocation_guard.h"
#include "tests/unit/firmware/publish/fixes.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

BoxHealth SomeHealth() {
  BoxHealth health;
  health.uptime_s = 100'000;
  health.temperature_celsius = -12.34;
  health.cameras = {{{60.0, 70'001}, {59.94, 5}}};
  health.radio_loss = 0.0125;
  health.filter_position = 3;
  health.can_sent_frames = 1'000'001;
  health.can_errors = 2;
  health.can_bus_off = 65'537;
  health.can_dropped_epochs = 4;
  health.modbus_clients = 7;
  health.modbus_clients_max = 32;
  return health;
}

EpochRules RulesWithOrigin() {
  EpochRules rules;
  rules.origin_s_m = {11, -20, 70'000};
  return rules;
}

}  // namespace

TEST_GROUP(RegisterMap) {
  RegisterMap map_{MakeIdentity("SN 7", "1.2.3", 0xCAFE1234), RulesWithOrigin()};
  RegisterImage image_;
  georef::GeoFixSet fixes_;
  BoxCondition box_ = GoodBox();
  BoxHealth health_ = SomeHealth();
  base::TimeNs now_ns_ = kExposureNs + 20 * base::kNsPerMs;

  void Publish() {
    const georef::GeoFix* leading = fixes_.targets.empty() ? nullptr : &fixes_.targets[0];
    map_.Update(MakeEpoch(leading, box_, RulesWithOrigin(), now_ns_), box_, health_, fixes_, now_ns_);
    map_.Read(now_ns_, image_);
  }
  void PublishTracked() {
    georef::GeoFix fix = TrackedFix();
    fix.position_s_m.z() = 70'000.5;
    fixes_.targets.push_back(fix);
    Publish();
  }
  std::uint16_t U16(unsigned address) const { return image_.words[address]; }
  std::int16_t I16(unsigned address) const { return static_cast<std::int16_t>(U16(address)); }
  std::uint32_t U32(unsigned address) const {
    return static_cast<std::uint32_t>(U16(address)) << 16 | U16(address + 1);
  }
  std::int32_t I32(unsigned address) const { return static_cast<std::int32_t>(U32(address)); }
  double F64(unsigned address) const {
    return std::bit_cast<double>(static_cast<std::uint64_t>(U32(address)) << 32 | U32(address + 2));
  }
  std::string Text(unsigned address) const {
    std::string text;
    for (unsigned i = 0; i < 32; ++i) {
      const char c = static_cast<char>(U16(address + i / 2) >> (i % 2 == 0 ? 8 : 0) & 0xFF);
      if (c != '\0') text += c;
    }
    return text;
  }
};

TEST(RegisterMap, ConstantsShowAWrongWordOrder) {
  PublishTracked();
  LONGS_EQUAL(0x4144, U16(0));
  LONGS_EQUAL(0x4954, U16(1));
  LONGS_EQUAL(0x0100, U16(2));
  LONGS_EQUAL(42, U16(3));
  LONGS_EQUAL(0x1234, U16(4));
  LONGS_EQUAL(0x5678, U16(5));
  DOUBLES_EQUAL(123.456F, std::bit_cast<float>(U32(6)), 0);
  LONGS_EQUAL(-2, I16(8));
}

TEST(RegisterMap, LiveBlockHoldsTheEpoch) {
  PublishTracked();
  LONGS_EQUAL(0x1234, U16(100));
  LONGS_EQUAL(2, U16(101));
  LONGS_EQUAL(1, U16(102));
  LONGS_EQUAL(20, U16(103));
  LONGS_EQUAL(-9000, I32(104));
  LONGS_EQUAL(402000, I32(106));
  LONGS_EQUAL(5000, I32(108));
  for (const unsigned attitude : {110U, 112U, 114U}) LONGS_EQUAL(INT32_MIN, I32(attitude));
  LONGS_EQUAL(50, U16(116));
  LONGS_EQUAL(20, U16(117));
  LONGS_EQUAL(2, U16(118));
  LONGS_EQUAL(1, U16(119));
  LONGS_EQUAL(0, U32(120));
  for (const unsigned tunnel : {122U, 124U, 126U, 130U, 132U}) LONGS_EQUAL(INT32_MIN, I32(tunnel));
  LONGS_EQUAL(INT16_MIN, I16(128));
  LONGS_EQUAL(INT16_MIN, I16(129));
  LONGS_EQUAL(1'700'000'000, U32(134));
  LONGS_EQUAL(123, U16(136));
  LONGS_EQUAL(3, U16(137));
  LONGS_EQUAL(4321, U16(138));
  LONGS_EQUAL(0x1234, U16(139));
  LONGS_EQUAL(0x1234, U16(140));
}

// Bit by bit, as the definition of the CRC goes; the code under test uses a table.
static std::uint16_t SlowCrc(const std::string& bytes) {
  unsigned crc = 0xFFFF;
  for (const char byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) {
      const bool in = ((static_cast<unsigned char>(byte) >> bit) & 1) != 0;
      const bool out = (crc & 0x8000U) != 0;
      crc = (crc << 1) & 0xFFFFU;
      if (in != out) crc ^= 0x1021;
    }
  }
  return static_cast<std::uint16_t>(crc);
}

TEST(RegisterMap, LiveBlockEndsInItsCrc) {
  PublishTracked();
  std::string bytes;
  for (unsigned address = 100; address <= 140; ++address) {
    bytes += static_cast<char>(U16(address) >> 8);
    bytes += static_cast<char>(U16(address) & 0xFF);
  }
  bytes += "\xFF\xA0";
  LONGS_EQUAL(SlowCrc(bytes), U16(141));
}

TEST(RegisterMap, FullCoordinatesAndOrigin) {
  PublishTracked();
  DOUBLES_EQUAL(10.1, F64(200), 0);
  DOUBLES_EQUAL(20.2, F64(204), 0);
  DOUBLES_EQUAL(70'000.5, F64(208), 0);
  LONGS_EQUAL(11, I32(220));
  LONGS_EQUAL(-20, I32(222));
  LONGS_EQUAL(70'000, I32(224));
  LONGS_EQUAL(0, U32(226));
  LONGS_EQUAL(0, U32(228));
  LONGS_EQUAL(0xCAFE1234, U32(230));
}

TEST(RegisterMap, Diagnostics) {
  PublishTracked();
  LONGS_EQUAL(100'000, U32(300));
  LONGS_EQUAL(0x0102, U16(302));
  LONGS_EQUAL(3, U16(303));
  LONGS_EQUAL(-123, I16(304));
  LONGS_EQUAL(6000, U16(306));
  LONGS_EQUAL(5994, U16(307));
  LONGS_EQUAL(70'001, U32(308));
  LONGS_EQUAL(5, U32(310));
  LONGS_EQUAL(125, U16(312));
  LONGS_EQUAL(3, U16(313));
  LONGS_EQUAL(1'000'001, U32(314));
  LONGS_EQUAL(2, U32(316));
  LONGS_EQUAL(65'537, U32(318));
  LONGS_EQUAL(4, U32(320));
  LONGS_EQUAL(7, U16(322));
  LONGS_EQUAL(32, U16(323));
}

TEST(RegisterMap, WhatABoxDoesNotHaveIsNotAvailable) {
  health_ = {};
  PublishTracked();
  LONGS_EQUAL(INT16_MIN, I16(304));
  LONGS_EQUAL(65535, U16(312));
  LONGS_EQUAL(65535, U16(313));
}

TEST(RegisterMap, TextsAreAscii) {
  PublishTracked();
  CHECK(Text(400) == "adit");
  CHECK(Text(416) == "adit edge box");
  CHECK(Text(432) == "SN 7");
  CHECK(Text(448) == "1.2.3");
  LONGS_EQUAL('a' * 256 + 'd', U16(400));
}

TEST(RegisterMap, LongAndForeignTextIsCutAndMarked) {
  const BoxIdentity identity = MakeIdentity(std::string(40, 'x'), "1.0\x80", 0);
  CHECK(TextOf(identity.serial) == std::string(32, 'x'));
  CHECK(TextOf(identity.version) == "1.0?");
}

TEST(RegisterMap, SerialAndVersionNumbersAreReadWhereTheyAreNumbers) {
  LONGS_EQUAL(4711, MakeIdentity("4711", "", 0).serial_number);
  LONGS_EQUAL(0, MakeIdentity("4711-B", "", 0).serial_number);
  LONGS_EQUAL(0, MakeIdentity("99999999999", "", 0).serial_number);
  const BoxIdentity identity = MakeIdentity("", "10.20.30-rc1", 0);
  CHECK((identity.version_numbers == std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST(RegisterMap, TargetsHaveTheirStructs) {
  fixes_.targets.push_back(TrackedFix());
  georef::GeoFix lost = TrackedFix();
  lost.state.points.status = stereo::FixStatus::kLost;
  lost.state.last_seen_ns = now_ns_ - 90 * base::kNsPerS;
  fixes_.targets.push_back(lost);
  georef::GeoFix rebuilt = TrackedFix();
  rebuilt.state.points.status = stereo::FixStatus::kRecovered;
  rebuilt.position_s_m.x() = 11.5;
  fixes_.targets.push_back(rebuilt);
  Publish();
  const int first[] = {1, 1, 1, 20};
  for (unsigned i = 0; i < 4; ++i) LONGS_EQUAL(first[i], U16(1000 + i));
  LONGS_EQUAL(-9000, I32(1004));
  LONGS_EQUAL(402'000, I32(1006));
  LONGS_EQUAL(-700'033'000, I32(1008));
  LONGS_EQUAL(54, U16(1010));  // sqrt(9 + 16 + 4) = 5.39 mm
  LONGS_EQUAL(12, U16(1011));
  LONGS_EQUAL(0, U16(1012));
  const int second[] = {2, 4, 0, 20};
  for (unsigned i = 0; i < 4; ++i) LONGS_EQUAL(second[i], U16(1020 + i));
  LONGS_EQUAL(INT32_MIN, I32(1024));
  LONGS_EQUAL(65535, U16(1030));
  LONGS_EQUAL(65535, U16(1031));
  LONGS_EQUAL(90, U16(1032));
  LONGS_EQUAL(3, U16(1040));
  LONGS_EQUAL(2, U16(1041));
  LONGS_EQUAL(5000, I32(1044));
  LONGS_EQUAL(0, U16(1060));
  LONGS_EQUAL(0, U16(1061));
  LONGS_EQUAL(65535, U16(1063));
  LONGS_EQUAL(65535, U16(1072));
}

TEST(RegisterMap, WithoutAPositionValuesAreNotAvailable) {
  Publish();
  LONGS_EQUAL(1, U16(101));
  LONGS_EQUAL(0, U16(102));
  LONGS_EQUAL(65535, U16(103));
  for (const unsigned address : {104U, 106U, 108U}) LONGS_EQUAL(INT32_MIN, I32(address));
  LONGS_EQUAL(65535, U16(116));
  LONGS_EQUAL(65535, U16(117));
  for (const unsigned address : {200U, 204U, 208U}) CHECK(std::isnan(F64(address)));
  LONGS_EQUAL(0, U32(134));
}

TEST(RegisterMap, BeforeTheFirstUpdateItIsInitAndNotAlive) {
  map_.Read(now_ns_, image_);
  LONGS_EQUAL(0, U16(101));
  LONGS_EQUAL(0, U16(102));
  LONGS_EQUAL(INT32_MIN, I32(104));
  LONGS_EQUAL(0, image_.discrete_inputs & 1);
}

TEST(RegisterMap, APublisherThatStoppedLeavesNothingValidBehind) {
  PublishTracked();
  map_.Read(kExposureNs + 101 * base::kNsPerMs, image_);
  LONGS_EQUAL(0, U16(102));
  LONGS_EQUAL(101, U16(103));
  LONGS_EQUAL(INT32_MIN, I32(104));
  LONGS_EQUAL(0, U16(1002));
  LONGS_EQUAL(1, image_.discrete_inputs & 1);
  map_.Read(now_ns_ + base::kNsPerS + 1, image_);
  LONGS_EQUAL(0, image_.discrete_inputs & 1);
}

TEST(RegisterMap, DiscreteInputsOfAWellBox) {
  PublishTracked();
  // alive, valid, cameras, radio, CAN, time sync, PLC heartbeat, georeference, sigma
  LONGS_EQUAL(0b0101'0111'1110'0011, image_.discrete_inputs);
}

TEST(RegisterMap, DiscreteInputsOfAnIllBox) {
  box_.faults = 0xFFFF;
  box_.clock = ClockSource::kHoldover;
  PublishTracked();
  // alive, fault, update pending
  LONGS_EQUAL(0b0000'1000'0001'0001, image_.discrete_inputs);
  LONGS_EQUAL(0xFFFF, U32(120));
}

TEST(RegisterMap, DiscreteInputsOfABoxInService) {
  box_.service = true;
  PublishTracked();
  LONGS_EQUAL(0b1101'0111'1110'0101, image_.discrete_inputs);
}

TEST(RegisterMap, UpdateAndReadAllocateNothing) {
  fixes_.targets.push_back(TrackedFix());
  const std::uint64_t before = support::AllocationCount();
  Publish();
  LONGS_EQUAL(0, support::AllocationCount() - before);
}

TEST(RegisterMap, OnlyTheAreasOfTheMapExist) {
  CHECK(RegistersExist(0, 9));
  CHECK_FALSE(RegistersExist(0, 10));
  CHECK_FALSE(RegistersExist(9, 1));
  CHECK(RegistersExist(100, 42));
  CHECK_FALSE(RegistersExist(99, 1));
  CHECK_FALSE(RegistersExist(142, 1));
  CHECK_FALSE(RegistersExist(211, 2));
  CHECK(RegistersExist(220, 12));
  CHECK(RegistersExist(300, 60));
  CHECK(RegistersExist(463, 1));
  CHECK_FALSE(RegistersExist(464, 1));
  CHECK(RegistersExist(1639, 1));
  CHECK_FALSE(RegistersExist(1640, 1));
  CHECK_FALSE(RegistersExist(65535, 125));
}

TEST(RegisterMap, NoTwoSignalsShareARegister) {
  std::array<int, kRegisterEnd> owners{};
  for (const SignalRow& row : Signals()) {
    if (!row.address) continue;
    CHECK(RegistersExist(*row.address, WordsOf(row.type)));
    for (unsigned i = 0; i < WordsOf(row.type); ++i) ++owners[*row.address + i];
  }
  for (const LabelRow& row : LabelRows()) {
    CHECK(RegistersExist(row.address, 16));
    for (unsigned i = 0; i < 16; ++i) ++owners[row.address + i];
  }
  ++owners[kLiveCrcAddress];
  for (const int count : owners) CHECK(count <= 1);
}

TEST(RegisterMap, NoTwoSignalsShareABitOnCan) {
  std::array<std::uint64_t, 16> taken{};
  for (const SignalRow& row : Signals()) {
    if (row.can.bits == 0) continue;
    const std::uint64_t bits = ((std::uint64_t{1} << row.can.bits) - 1) << row.can.start_bit;
    CHECK((bits >> 32) == 0);
    CHECK((taken[row.can.slot] & bits) == 0);
    taken[row.can.slot] |= bits;
  }
}

}  // namespace adit::publish
