// GVCP and GVSP byte for byte, against packets written by hand after the GigE Vision conventions.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "drivers/sim/gige_camera.h"
#include "drivers/sim/gige_protocol.h"
#include "drivers/sim/gige_registers.h"

#include <CppUTest/TestHarness.h>

using adit::sim::FormatGvspHeader;
using adit::sim::FormatLeader;
using adit::sim::FormatTrailer;
using adit::sim::GigeCamera;
using adit::sim::GvspContent;
using adit::sim::NextFrameId;
using adit::sim::ParseGvcp;
using adit::sim::ParseResend;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// Pairs of hex digits; blanks between them are for the reader.
Bytes Hex(const std::string& text) {
  Bytes bytes;
  std::string pair;
  for (const char c : text) {
    if (c == ' ') continue;
    pair += c;
    if (pair.size() < 2) continue;
    bytes.push_back(static_cast<std::uint8_t>(std::strtoul(pair.c_str(), nullptr, 16)));
    pair.clear();
  }
  return bytes;
}

std::string Text(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02X", byte);
    text += digits;
  }
  return text;
}

void CheckBytes(const std::string& expected, std::span<const std::uint8_t> actual) {
  STRCMP_EQUAL(Text(Hex(expected)).c_str(), Text(actual).c_str());
}

/// A text in a field of that many bytes, as hex.
std::string Field(const std::string& text, std::size_t bytes) {
  Bytes field(text.begin(), text.end());
  field.resize(bytes);
  return Text(field);
}

adit::sim::GigeOptions Options() {
  adit::sim::GigeOptions options;
  options.identity.serial = "SIM7";
  options.identity.address = 0x7F000002;
  options.identity.width_px = 320;
  options.identity.height_px = 240;
  options.frame_bytes = 320 * 240;
  return options;
}

}  // namespace

/// A camera that is not on any network: only its answers.
TEST_GROUP(Gvcp) {
  GigeCamera camera{Options(), [](std::uint64_t, std::uint8_t*) {}};
  Bytes Ask(const std::string& packet, std::uint16_t port = 1) {
    sockaddr_in peer{};
    peer.sin_family = AF_INET;
    peer.sin_port = port;
    return camera.Reply(Hex(packet), peer);
  }
  void TakeControl() {
    CheckBytes("0000 0083 0004 0001 0000 0001", Ask("42 01 0082 0008 0001 00000A00 00000002"));
  }
  std::string Register(const std::string& address) {
    const Bytes reply = Ask("42 01 0080 0004 0009" + address);
    CheckBytes("0000 0081 0004 0009", std::span(reply).first(8));
    return Text(std::span(reply).subspan(8));
  }
};

TEST(Gvcp, TellsWhoItIs) {
  const std::string expected =
      "0000 0003 00F8 1234"
      "0002 0000 80000001 0000 02AD 7F000002 00000007 00000005"
      "000000000000000000000000 7F000002 000000000000000000000000 FF000000"
      "000000000000000000000000 00000000" +
      Field("adit", 32) + Field("simulated camera", 32) + Field("1.0", 32) + Field("not a real camera", 48) +
      Field("SIM7", 16) + Field("", 16);
  CheckBytes(expected, Ask("42 01 0002 0000 1234"));
  // With leave to answer by broadcast.
  CheckBytes(expected, Ask("42 11 0002 0000 1234"));
}

TEST(Gvcp, ReadsOneRegisterOrMany) {
  CheckBytes("0000 0081 0004 ABCD 00020000", Ask("42 01 0080 0004 ABCD 00000000"));
  CheckBytes("0000 0081 000C 0001 00000BB8 3B9ACA00 00000140",
             Ask("42 01 0080 000C 0001 00000938 00000940 00010000"));
}

TEST(Gvcp, ReadsMemory) {
  CheckBytes("0000 0085 0008 0002 000000D8 53494D37", Ask("42 01 0084 0008 0002 000000D8 0000 0004"));
  // The description is where the camera says it is.
  CheckBytes("0000 0085 0018 0003 00000200" + Field("Local:adit.xml;20000", 20),
             Ask("42 01 0084 0008 0003 00000200 0000 0014"));
  CheckBytes("0000 0085 000C 0004 00020000" + Field("<?xml ve", 8),
             Ask("42 01 0084 0008 0004 00020000 0000 0008"));
  // The longest answer that fits 576 bytes of IP packet.
  LONGS_EQUAL(548, Ask("42 01 0084 0008 0005 00020000 0000 0218").size());
  CheckBytes("8002 0085 0000 0005", Ask("42 01 0084 0008 0005 00020000 0000 021C"));
  CheckBytes("8002 0085 0000 0005", Ask("42 01 0084 0008 0005 00020000 0000 0000"));
}

TEST(Gvcp, WritesRegisters) {
  TakeControl();
  CheckBytes("0000 0083 0004 0002 0000 0002",
             Ask("42 01 0082 0010 0002 00000D04 40002328 00000D18 7F000001"));
  STRCMP_EQUAL("40002328", Register("00000D04").c_str());
  STRCMP_EQUAL("7F000001", Register("00000D18").c_str());
}

TEST(Gvcp, SaysHowManyRegistersWereWrittenBeforeTheOneThatFailed) {
  TakeControl();
  CheckBytes("8004 0083 0004 0002 0000 0001",
             Ask("42 01 0082 0010 0002 00000D18 7F000001 00000000 00000000"));
  STRCMP_EQUAL("00020000", Register("00000000").c_str());
}

TEST(Gvcp, WritesMemory) {
  TakeControl();
  CheckBytes("0000 0087 0004 0003 0000 0008", Ask("42 01 0086 000C 0003 00010030 408F400000000000"));
  CheckBytes("0000 0085 000C 0004 00010030 408F400000000000", Ask("42 01 0084 0008 0004 00010030 0000 0008"));
}

TEST(Gvcp, OnlyTheControllerWrites) {
  CheckBytes("8006 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00000D18 7F000001"));
  TakeControl();
  CheckBytes("8006 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00000D18 7F000001", 2));
  CheckBytes("8006 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00000A00 00000002", 2));
  CheckBytes("0000 0081 0004 0001 00000002", Ask("42 01 0080 0004 0001 00000A00", 2));
  // Given back, anyone may take it.
  CheckBytes("0000 0083 0004 0001 0000 0001", Ask("42 01 0082 0008 0001 00000A00 00000000"));
  CheckBytes("0000 0083 0004 0001 0000 0001", Ask("42 01 0082 0008 0001 00000A00 00000002", 2));
}

TEST(Gvcp, ThePayloadGoesWithTheFormat) {
  TakeControl();
  STRCMP_EQUAL("00012C00", Register("00010020").c_str());
  Ask("42 01 0082 0008 0001 00010008 01100005");
  STRCMP_EQUAL("00025800", Register("00010020").c_str());
  Ask("42 01 0082 0008 0001 00010004 00000078");
  STRCMP_EQUAL("00012C00", Register("00010020").c_str());
  CheckBytes("8004 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00010020 00000000"));
}

TEST(Gvcp, SaysWhatItDoesNotKnow) {
  CheckBytes("8001 0005 0000 0007", Ask("42 01 0004 0000 0007"));
  CheckBytes("8001 0000 0000 0007", Ask("42 01 FFFF 0000 0007"));
}

TEST(Gvcp, RefusesAddressesBetweenWords) {
  CheckBytes("8005 0081 0000 0001", Ask("42 01 0080 0004 0001 00000002"));
  CheckBytes("8005 0085 0000 0001", Ask("42 01 0084 0008 0001 00000001 0000 0004"));
  CheckBytes("8005 0085 0000 0001", Ask("42 01 0084 0008 0001 00000004 0000 0003"));
  TakeControl();
  CheckBytes("8005 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00010002 00000001"));
  CheckBytes("8005 0087 0004 0001 0000 0000", Ask("42 01 0086 0006 0001 00010000 0001"));
}

TEST(Gvcp, RefusesAddressesOutside) {
  CheckBytes("8003 0081 0000 0001", Ask("42 01 0080 0004 0001 00030000"));
  CheckBytes("8003 0081 0000 0001", Ask("42 01 0080 0004 0001 FFFFFFFC"));
  CheckBytes("8003 0085 0000 0001", Ask("42 01 0084 0008 0001 0002FFFC 0000 0008"));
  TakeControl();
  CheckBytes("8003 0083 0004 0001 0000 0000", Ask("42 01 0082 0008 0001 00030000 00000001"));
  CheckBytes("8003 0087 0004 0001 0000 0000", Ask("42 01 0086 0008 0001 FFFFFFFC 00000001"));
}

TEST(Gvcp, RefusesListsThatAreNotWhole) {
  CheckBytes("8002 0081 0000 0001", Ask("42 01 0080 0000 0001"));
  CheckBytes("8002 0081 0000 0001", Ask("42 01 0080 0006 0001 00000000 0000"));
  CheckBytes("8002 0085 0000 0001", Ask("42 01 0084 0004 0001 00000000"));
  TakeControl();
  CheckBytes("8002 0083 0004 0001 0000 0000", Ask("42 01 0082 0004 0001 00010000"));
  CheckBytes("8002 0083 0004 0001 0000 0000", Ask("42 01 0082 000C 0001 00010000 00000001 00010004"));
  CheckBytes("8002 0087 0004 0001 0000 0000", Ask("42 01 0086 0004 0001 00010000"));
  STRCMP_EQUAL("00000140", Register("00010000").c_str());
}

TEST(Gvcp, IsSilentToWhatIsNoPacket) {
  for (const char* packet : {"", "42", "42 01 0002 0000 00",  // short
                             "43 01 0002 0000 0001",          // another key
                             "42 01 0002 0001 0001",          // less than it says
                             "42 01 0002 0000 0001 00",       // more than it says
                             "42 01 0080 0004 0001 000000"}) {
    LONGS_EQUAL(0, Ask(packet).size());
  }
  const std::string too_long = "42 01 0080 0220 0001" + Text(Bytes(544));
  LONGS_EQUAL(0, Ask(too_long).size());
}

TEST(Gvcp, IsSilentWhenNoAcknowledgeIsWanted) {
  LONGS_EQUAL(0, Ask("42 00 0002 0000 0001").size());
  LONGS_EQUAL(0, Ask("42 00 0080 0004 0001 00000002").size());
  LONGS_EQUAL(0, Ask("42 01 0040 000C 0001 0000 0001 00000000 00000001").size());  // answered by the stream
  // The command is obeyed all the same.
  LONGS_EQUAL(0, Ask("42 00 0082 0008 0001 00000A00 00000002").size());
  STRCMP_EQUAL("00000002", Register("00000A00").c_str());
}

TEST_GROUP(GvcpParse){};

TEST(GvcpParse, TakesACommandApart) {
  const Bytes packet = Hex("42 01 0080 0004 BEEF 00000A00");
  const auto command = ParseGvcp(packet);
  CHECK(command.has_value());
  CHECK(command->code == adit::sim::GvcpCode::kReadRegister);
  LONGS_EQUAL(0x80, command->code_number);
  CHECK(command->wants_acknowledge);
  LONGS_EQUAL(0xBEEF, command->id);
  CheckBytes("00000A00", command->payload);
}

TEST(GvcpParse, TakesAResendApart) {
  // The upper byte of a packet id is reserved.
  const auto request = ParseResend(Hex("0000 FFFE AB000010 CD000123"));
  CHECK(request.has_value());
  LONGS_EQUAL(0xFFFE, request->frame_id);
  LONGS_EQUAL(0x10, request->first);
  LONGS_EQUAL(0x123, request->last);
}

TEST(GvcpParse, RefusesAResendThatIsShortOrBackwards) {
  CHECK(!ParseResend(Hex("0000 0001 00000010 000001")).has_value());
  CHECK(!ParseResend(Hex("0000 0001 00000011 00000010")).has_value());
  CHECK(ParseResend(Hex("0000 0001 00000010 00000010")).has_value());
}

TEST_GROUP(Gvsp) {
  const adit::sim::GvspFrame frame{0xFFFF, 0x0123456789ABCDEF, adit::sim::kMono12, 320, 240};
};

TEST(Gvsp, Leader) {
  CheckBytes(
      "0000 FFFF 01 000000"
      "0000 0001 01234567 89ABCDEF 01100005 00000140 000000F0 00000000 00000000 0000 0000",
      FormatLeader(frame));
}

TEST(Gvsp, PayloadHeader) {
  CheckBytes("0000 0102 03 ABCDEF", FormatGvspHeader(0x0102, GvspContent::kPayload, 0xABCDEF));
}

TEST(Gvsp, Trailer) { CheckBytes("0000 FFFF 02 000036 0000 0001 000000F0", FormatTrailer(frame, 0x36)); }

TEST(Gvsp, AfterTheLastFrameIdComesOne) {
  LONGS_EQUAL(2, NextFrameId(1));
  LONGS_EQUAL(65535, NextFrameId(65534));
  LONGS_EQUAL(1, NextFrameId(65535));
}
