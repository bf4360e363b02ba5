#include "drivers/modbus/mbap.h"

#include <algorithm>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace adit::modbus {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kRead{0x12, 0x34, 0, 0, 0, 6, 1, 4, 0, 100, 0, 42};

}  // namespace

TEST_GROUP(Mbap) {
  MbapStream stream_;
  void Feed(const Bytes& bytes) {
    CHECK(stream_.Room().size() >= bytes.size());
    std::copy(bytes.begin(), bytes.end(), stream_.Room().begin());
    stream_.Fill(bytes.size());
  }
};

TEST(Mbap, CutsARequestOutOfTheStream) {
  Feed(kRead);
  const auto frame = stream_.First();
  LONGS_EQUAL(0x1234, frame->transaction);
  CHECK(std::ranges::equal(frame->message, Bytes{1, 4, 0, 100, 0, 42}));
  CHECK_FALSE(stream_.Partial());
  stream_.Consume();
  CHECK_FALSE(stream_.First().has_value());
}

TEST(Mbap, WaitsForTheLastByte) {
  for (const std::uint8_t byte : kRead) {
    CHECK_FALSE(stream_.First().has_value());
    Feed({byte});
  }
  CHECK(stream_.First().has_value());
}

TEST(Mbap, KeepsWhatFollows) {
  Feed(kRead);
  Feed(kRead);
  Feed({0x55});
  stream_.Consume();
  CHECK(stream_.First().has_value());
  stream_.Consume();
  CHECK_FALSE(stream_.First().has_value());
  CHECK(stream_.Partial());
}

TEST(Mbap, RefusesAWrongProtocolAsSoonAsItShows) {
  Feed({0, 1, 0});
  CHECK_FALSE(stream_.Malformed());
  Feed({1});
  CHECK(stream_.Malformed());
  CHECK_FALSE(stream_.First().has_value());
}

TEST(Mbap, RefusesLengthsThatNoRequestHas) {
  for (const unsigned length : {0U, 1U, 255U, 256U, 65535U}) {
    stream_ = {};
    Feed({0, 1, 0, 0, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length & 0xFF)});
    CHECK(stream_.Malformed());
  }
  for (const unsigned length : {2U, 254U}) {
    stream_ = {};
    Feed({0, 1, 0, 0, 0, static_cast<std::uint8_t>(length)});
    CHECK_FALSE(stream_.Malformed());
  }
}

TEST(Mbap, HasRoomForTheLongestRequestWheneverNoneIsComplete) {
  Bytes longest{0, 1, 0, 0, 0, 254};
  longest.resize(kFrameMax, 0xAA);
  while (stream_.Room().size() >= longest.size()) Feed(longest);
  const std::size_t room = stream_.Room().size();
  Feed(Bytes(longest.begin(), longest.begin() + static_cast<std::ptrdiff_t>(room)));
  CHECK(stream_.Room().empty());
  CHECK(stream_.First().has_value());
}

TEST(Mbap, HeaderHoldsTransactionAndLength) {
  std::array<std::uint8_t, kMbapLength> header{9, 9, 9, 9, 9, 9};
  WriteMbap(header, 0xABCD, 254);
  CHECK((header == std::array<std::uint8_t, kMbapLength>{0xAB, 0xCD, 0, 0, 0, 254}));
}

}  // namespace adit::modbus
