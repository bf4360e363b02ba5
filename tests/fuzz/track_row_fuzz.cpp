// Hostile bytes through the track reader: whatever it accepts, it must write and read again to the same.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "firmware/pipeline/track_row.h"

namespace {

const std::string kGood =
    "1700000000123456789,4711,loader,recovered,1.250000,-0.500000,40.125000,0.000100,0.000200,0.001000,"
    "0.600000,0.000000,0.800000,1.000000,2.000000,3.000000,4.000000,5.000000,6.000000,7.000000,8.000000,"
    "9.000000,10.000000,11.000000,12.000000,2|3,1.500012,0.020000";

void CheckRow(std::string_view line) {
  const auto row = adit::pipeline::ParseTrackRow(line, "fuzz");
  if (!row) {
    ADIT_REQUIRE(!row.error().detail.empty());
    return;
  }
  const std::string once = adit::pipeline::FormatTrackRow(*row);
  const auto again = adit::pipeline::ParseTrackRow(once, "fuzz");
  ADIT_REQUIRE(again);
  ADIT_REQUIRE(adit::pipeline::FormatTrackRow(*again) == once);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  CheckRow(bytes);
  const auto rows = adit::pipeline::ParseTrack(bytes, "fuzz");
  ADIT_REQUIRE(!rows || size > adit::pipeline::TrackHeader().size());
  // Random bytes rarely make a row: put them, as signs that rows are made of, into one that is good.
  if (size < 2) return 0;
  constexpr std::string_view kSigns = "0123456789.,-+eE|nainftylost \r\n";
  std::string signs;
  for (const char byte : bytes.substr(2, 8)) signs += kSigns[static_cast<std::uint8_t>(byte) % kSigns.size()];
  std::string damaged = kGood;
  const std::size_t at = (data[0] * std::size_t{251} + data[1]) % damaged.size();
  damaged.replace(at, data[0] % 8U, signs);
  CheckRow(damaged);
  const auto all =
      adit::pipeline::ParseTrack(std::string(adit::pipeline::TrackHeader()) + "\n" + damaged + "\n", "fuzz");
  ADIT_REQUIRE(!all || all->size() <= kGood.size());
  return 0;
}
