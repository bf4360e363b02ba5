#include "firmware/publish/box_record.h"

#include <algorithm>
#include <charconv>

namespace adit::publish {
namespace {

// Reads a number off the front of `text` and past the dot behind it; 0 if there is none or it does not fit.
template <class T>
T TakeNumber(std::string_view& text) {
  T number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (text.starts_with('.')) text.remove_prefix(1);
  return error == std::errc() ? number : T{0};
}

}  // namespace

Label MakeLabel(std::string_view text) {
  Label label{};
  const std::size_t length = std::min(text.size(), label.size());
  for (std::size_t i = 0; i < length; ++i) {
    const bool printable = text[i] >= ' ' && text[i] <= '~';
    label[i] = printable ? text[i] : '?';
  }
  return label;
}

std::string_view TextOf(const Label& label) {
  const auto end = std::find(label.begin(), label.end(), '\0');
  return {label.data(), static_cast<std::size_t>(end - label.begin())};
}

BoxIdentity MakeIdentity(std::string_view serial, std::string_view version, std::uint32_t config_crc32) {
  BoxIdentity identity;
  identity.vendor = MakeLabel("adit");
  identity.product = MakeLabel("adit edge box");
  identity.serial = MakeLabel(serial);
  identity.version = MakeLabel(version);
  identity.config_crc32 = config_crc32;
  for (std::uint8_t& number : identity.version_numbers) number = TakeNumber<std::uint8_t>(version);
  const std::uint32_t number = TakeNumber<std::uint32_t>(serial);
  identity.serial_number = serial.empty() ? number : 0;
  return identity;
}

}  // namespace adit::publish
