#include "firmware/pipeline/track_row.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include <CppUTest/TestHarness.h>

using adit::pipeline::FormatTrackRow;
using adit::pipeline::LoadTrack;
using adit::pipeline::ParseTrack;
using adit::pipeline::ParseTrackRow;
using adit::pipeline::TrackHeader;
using adit::pipeline::TrackRow;
using adit::stereo::FixStatus;
using Eigen::Vector3d;

namespace {

const std::string kTracked =
    "1700000000123456789,4711,loader,tracked,1.250000,-0.500000,40.125000,0.000100,0.000200,0.001000,"
    "0.600000,0.000000,0.800000,1.000000,2.000000,3.000000,4.000000,5.000000,6.000000,7.000000,8.000000,"
    "9.000000,10.000000,11.000000,12.000000,,1.500012,0.020000";
const std::string kLost = "1700000000123456789,4711,loader,lost,,,,,,,,,,,,,,,,,,,,,,,,";

TrackRow Tracked() {
  TrackRow row;
  row.timestamp_ns = 1'700'000'000'123'456'789;
  row.trigger = 4711;
  row.target = "loader";
  row.status = FixStatus::kTracked;
  row.position_m = {1.25, -0.5, 40.125};
  row.sigma_m = {1e-4, 2e-4, 1e-3};
  row.direction = {0.6, 0, 0.8};
  for (std::size_t i = 0; i < 4; ++i)
    row.leds_m[i] = Vector3d(1, 2, 3) + 3.0 * static_cast<double>(i) * Vector3d::Ones();
  row.bar_m = 1.500012;
  row.reprojection_px = 0.02;
  return row;
}

/// What ParseTrackRow says of `line`: "" if nothing is wrong.
std::string Complaint(const std::string& line) {
  const auto row = ParseTrackRow(line, "t.csv:2");
  return row ? "" : row.error().Line();
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_GROUP(TrackRow){};

TEST(TrackRow, WritesARowAsTheDesignSays) {
  STRCMP_EQUAL(kTracked.c_str(), FormatTrackRow(Tracked()).c_str());
}

TEST(TrackRow, LeavesEveryNumberOfALostTargetEmpty) {
  TrackRow row = Tracked();
  row.status = FixStatus::kLost;
  STRCMP_EQUAL(kLost.c_str(), FormatTrackRow(row).c_str());
}

TEST(TrackRow, HasAsManyFieldsAsTheHeader) {
  const auto commas = [](std::string_view text) { return std::count(text.begin(), text.end(), ','); };
  LONGS_EQUAL(27, commas(TrackHeader()));
  LONGS_EQUAL(27, commas(kTracked));
  LONGS_EQUAL(27, commas(kLost));
}

TEST(TrackRow, NamesRecoveredLeds) {
  TrackRow row = Tracked();
  row.status = FixStatus::kRecovered;
  row.recovered_mask = 0b0110;
  const std::string line = FormatTrackRow(row);
  STRCMP_CONTAINS(",recovered,", line.c_str());
  STRCMP_CONTAINS(",2|3,", line.c_str());
  LONGS_EQUAL(0b0110, ParseTrackRow(line, "")->recovered_mask);
}

TEST(TrackRow, ReadsBackWhatItWrote) {
  for (const std::string& line : {kTracked, kLost}) {
    const auto row = ParseTrackRow(line, "");
    CHECK(!!row);
    STRCMP_EQUAL(line.c_str(), FormatTrackRow(*row).c_str());
  }
  const auto row = ParseTrackRow(kTracked, "");
  CHECK(row->timestamp_ns == 1'700'000'000'123'456'789);
  DOUBLES_EQUAL(12, row->leds_m[3].z(), 0);
  DOUBLES_EQUAL(40.125, row->position_m.z(), 0);
}

TEST(TrackRow, KeepsAMicrometreOnTheSiteGrid) {
  TrackRow row = Tracked();
  row.position_m = {546123.123456, 5178456.654321, -400.000001};
  const auto back = ParseTrackRow(FormatTrackRow(row), "");
  CHECK(!!back);
  CHECK((back->position_m - row.position_m).norm() < 1e-6);
}

TEST(TrackRow, WritesNoMinusBeforeZero) {
  TrackRow row = Tracked();
  row.position_m = {-1e-9, -0.0, 1e-9};
  STRCMP_CONTAINS(",tracked,0.000000,0.000000,0.000000,", FormatTrackRow(row).c_str());
}

TEST(TrackRow, TakesItsNumbersFromTheFix) {
  adit::georef::GeoFix fix;
  fix.state.points.status = FixStatus::kTracked;
  fix.state.points.bar_m = 1.5;
  fix.state.mid_exposure_ns = 5, fix.state.trigger = 6;
  fix.position_s_m = {1, 2, 3};
  fix.covariance_s_m2 = Vector3d(4e-6, 9e-6, 16e-6).asDiagonal();
  fix.leds_s_m[2] = {7, 8, 9};
  const TrackRow row = adit::pipeline::TrackRowOf(fix, "bolter");
  STRCMP_EQUAL("bolter", row.target.c_str());
  DOUBLES_EQUAL(0.003, row.sigma_m.y(), 1e-12);
  DOUBLES_EQUAL(8, row.leds_m[2].y(), 0);
  CHECK(row.timestamp_ns == 5 && row.trigger == 6);
}

TEST(TrackRow, RefusesAMalformedRowWithPlaceValueAndWhatIsAllowed) {
  STRCMP_EQUAL("", Complaint(kTracked).c_str());
  for (const auto& [line, part] : std::vector<std::pair<std::string, std::string>>{
           {kTracked + ",", "29 fields"},
           {"", "1 fields"},
           {Replaced(kTracked, "4711", "-3"), "trigger is '-3'"},
           {Replaced(kTracked, "1700000000123456789", "99999999999999999999"), "timestamp_ns"},
           {Replaced(kTracked, "loader", ""), "target is empty"},
           {Replaced(kTracked, "tracked", "found"), "'found'; it must be tracked"},
           {Replaced(kTracked, "1.250000", ""), "must be a number"},
           {Replaced(kTracked, "1.250000", "nan"), "must be a number"},
           {Replaced(kTracked, "1.250000", "inf"), "must be a number"},
           {Replaced(kTracked, "1.250000", "1.25m"), "'1.25m'"},
           {Replaced(kTracked, ",,1.5", ",5,1.5"), "recovered is '5'"},
           {Replaced(kTracked, ",,1.5", ",2|,1.5"), "recovered is '2|'"},
           {Replaced(kTracked, ",,1.5", ",2,1.5"), "a recovered row names its LEDs"},
           {Replaced(kTracked, "tracked", "recovered"), "names its LEDs"},
           {Replaced(kTracked, "tracked", "lost"), "a lost row has none"},
       }) {
    const std::string complaint = Complaint(line);
    STRCMP_CONTAINS("t.csv:2: ", complaint.c_str());
    STRCMP_CONTAINS(part.c_str(), complaint.c_str());
    CHECK(complaint.find('\n') == std::string::npos);
  }
}

TEST(TrackRow, ReadsAWholeFileAndNamesTheLineThatIsWrong) {
  const std::string header(TrackHeader());
  const auto rows = ParseTrack(header + "\r\n" + kTracked + "\r\n\n" + kLost, "t.csv");
  CHECK(!!rows);
  LONGS_EQUAL(2, rows->size());
  STRCMP_CONTAINS("t.csv:3: ",
                  ParseTrack(header + "\n" + kTracked + "\nx\n", "t.csv").error().Line().c_str());
  STRCMP_CONTAINS("header", ParseTrack(kTracked + "\n", "t.csv").error().Line().c_str());
  STRCMP_CONTAINS("empty", ParseTrack("", "t.csv").error().Line().c_str());
}

TEST(TrackRow, LoadsAFileAndSaysWhenThereIsNone) {
  const char* const path = "track_row_test.tmp.csv";
  std::ofstream(path) << TrackHeader() << '\n' << kTracked << '\n';
  const auto rows = LoadTrack(path);
  std::remove(path);
  CHECK(!!rows);
  LONGS_EQUAL(1, rows->size());
  const auto missing = LoadTrack("no_such_track.csv");
  CHECK_FALSE(missing);
  STRCMP_CONTAINS("no_such_track.csv", missing.error().Line().c_str());
  LONGS_EQUAL(1, missing.error().ExitCode());
}
