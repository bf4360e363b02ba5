// What a file says of how it came about.
#pragma once

#include <string>
#include <string_view>

#include "firmware/base/time.h"

namespace adit::host {

/// CRC-32 as in Ethernet and zip (IEEE 802.3), eight hexadecimal digits: tells files apart.
std::string Crc32(std::string_view bytes);

/// ISO 8601 to the second, UTC: "2024-05-06T07:08:09Z".
std::string Utc(base::TimeNs time_ns);

}  // namespace adit::host
