#include "drivers/modbus/mbap.h"

#include <algorithm>

namespace adit::modbus {
namespace {

std::size_t WordAt(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] * std::size_t{256} + bytes[at + 1];
}

}  // namespace

bool MbapStream::Malformed() const {
  // As early as the bytes allow: garbage is not waited for.
  if (size_ >= 4 && WordAt(bytes_, 2) != 0) return true;
  if (size_ < kMbapLength) return false;
  const std::size_t length = WordAt(bytes_, 4);
  return length < kMessageMin || length > kMessageMax;
}

std::size_t MbapStream::FirstLength() const { return kMbapLength + WordAt(bytes_, 4); }

std::optional<Frame> MbapStream::First() const {
  if (size_ < kMbapLength || Malformed() || size_ < FirstLength()) return std::nullopt;
  const std::span<const std::uint8_t> all(bytes_);
  return Frame{static_cast<std::uint16_t>(WordAt(all, 0)),
               all.subspan(kMbapLength, FirstLength() - kMbapLength)};
}

void MbapStream::Consume() {
  if (!First()) return;
  const std::size_t length = FirstLength();
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(length),
            bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
  size_ -= length;
}

void WriteMbap(std::span<std::uint8_t, kMbapLength> header, std::uint16_t transaction,
               std::size_t message_length) {
  header[0] = static_cast<std::uint8_t>(transaction >> 8);
  header[1] = static_cast<std::uint8_t>(transaction & 0xFFU);
  header[2] = header[3] = 0;
  header[4] = static_cast<std::uint8_t>(message_length >> 8);
  header[5] = static_cast<std::uint8_t>(message_length & 0xFFU);
}

}  // namespace adit::modbus
