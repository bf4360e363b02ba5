// Text that is safe inside HTML and JSON.
#pragma once

#include <string>
#include <string_view>

namespace adit::host {

/// &, <, > and both quotes as entities.
std::string HtmlText(std::string_view text);

/// A JSON string with its quotes (RFC 8259).
std::string JsonText(std::string_view text);

/// A JSON number of nine digits; `null` for what is not finite.
std::string JsonNumber(double value);

/// A number as people read it: `decimals` digits after the point, a true minus sign, "–" for what is not
/// finite.
std::string ReadableNumber(double value, int decimals);

}  // namespace adit::host
