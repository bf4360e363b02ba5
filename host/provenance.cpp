#include "host/provenance.h"

#include <boost/crc.hpp>
#include <ctime>
#include <iomanip>
#include <sstream>

namespace adit::host {

std::string Crc32(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  std::ostringstream text;
  text << std::hex << std::setw(8) << std::setfill('0') << crc.checksum();
  return text.str();
}

std::string Utc(base::TimeNs time_ns) {
  const std::time_t seconds = time_ns / base::kNsPerS;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::ostringstream text;
  text << std::put_time(&parts, "%Y-%m-%dT%H:%M:%SZ");
  return text.str();
}

}  // namespace adit::host
