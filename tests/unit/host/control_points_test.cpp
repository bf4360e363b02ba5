#include "host/control_points.h"

#include <cstdio>
#include <fstream>
#include <string>

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::ControlFile;
using adit::host::LoadControlPoints;
using adit::host::ParseControlCsv;

const char* const kPath = "control_points_test.tmp.csv";
const std::string kHeader = "name,easting_m,northing_m,height_m,sigma_m\n";

ControlFile Parsed(const std::string& text) {
  auto points = ParseControlCsv(text, "p.csv");
  if (!points) FAIL(points.error().Line().c_str());
  return {"p.csv", "", *points};
}

std::string Complaint(const std::string& text) {
  const auto points = ParseControlCsv(text, "p.csv");
  return points ? "" : points.error().Line();
}

std::string LoadComplaint(const std::string& text, const std::string& path = kPath) {
  std::ofstream(path, std::ios::binary) << text;
  const auto file = LoadControlPoints(path, std::nullopt);
  std::remove(path.c_str());
  return file ? "" : file.error().Line();
}

}  // namespace

TEST_GROUP(ControlPoints){};

TEST(ControlPoints, ReadsColumnsInAnyOrder) {
  const auto file =
      Parsed("\xEF\xBB\xBFnorthing_m, easting_m ,height_m,name\r\n1200000.5,2600000.25,431,P 1\r\n\r\n");
  LONGS_EQUAL(1, file.points.size());
  STRCMP_EQUAL("P 1", file.points[0].name.c_str());
  LONGS_EQUAL(2, file.points[0].line);
  CHECK_TRUE(*file.PositionOf(file.points[0]) == Eigen::Vector3d(2600000.25, 1200000.5, 431));
  CHECK_FALSE(file.points[0].sigma_m.has_value());
}

TEST(ControlPoints, ReadsSigmasWhereTheyStand) {
  const auto file = Parsed(kHeader + "a,1,2,3,0.0015\nb,1,2,3,\n");
  DOUBLES_EQUAL(0.0015, *file.points[0].sigma_m, 0);
  CHECK_FALSE(file.points[1].sigma_m.has_value());
}

TEST(ControlPoints, AnEmptyHeightIsNoZero) {
  const auto file = Parsed(kHeader + "a,1,2,,\n");
  const auto position = file.PositionOf(file.points[0]);
  CHECK_FALSE(!!position);
  STRCMP_CONTAINS("p.csv:2: point a: word height_m has no value", position.error().Line().c_str());
  LONGS_EQUAL(2, position.error().ExitCode());
}

TEST(ControlPoints, APointThatStandsTwiceIsRefusedWithBothLines) {
  const auto file = Parsed(kHeader + "a,1,2,3,\nb,1,2,3,\na,1,2,4,\n");
  STRCMP_CONTAINS("p.csv:4: point a stands in line 2 too", file.Find("a").error().Line().c_str());
  CHECK_TRUE(*file.Find("b") == &file.points[1]);
  CHECK_TRUE(*file.Find("c") == nullptr);
}

TEST(ControlPoints, NamesFileLineColumnAndValue) {
  STRCMP_CONTAINS("p.csv:1: column 'x' is unknown", Complaint("name,x\n").c_str());
  STRCMP_CONTAINS("column height_m is missing", Complaint("name,easting_m,northing_m\n").c_str());
  STRCMP_CONTAINS("twice", Complaint("name,name,easting_m,northing_m,height_m\n").c_str());
  STRCMP_CONTAINS("p.csv:2: has 4 fields; the header has 5", Complaint(kHeader + "a,1,2,3\n").c_str());
  STRCMP_CONTAINS("p.csv:2: name is empty", Complaint(kHeader + ",1,2,3,\n").c_str());
  STRCMP_CONTAINS("northing_m is '2x'", Complaint(kHeader + "a,1,2x,3,\n").c_str());
  STRCMP_CONTAINS("easting_m is 'nan'", Complaint(kHeader + "a,nan,2,3,\n").c_str());
  STRCMP_CONTAINS("easting_m is '1e9'; it must be a number from -1e8 to 1e8",
                  Complaint(kHeader + "a,1e9,2,3,\n").c_str());
  STRCMP_CONTAINS("sigma_m is '0'; it must be a number above 0, at most 1",
                  Complaint(kHeader + "a,1,2,3,0\n").c_str());
}

TEST(ControlPoints, LoadsByTheEndingOfTheFile) {
  STRCMP_EQUAL("", LoadComplaint(kHeader + "a,1,2,3,\n").c_str());
  STRCMP_EQUAL(
      "", LoadComplaint("*110001+0000000000009001 81..10+0000000698460332\n", "control_points_test.tmp.GSI")
              .c_str());
  STRCMP_CONTAINS("'.txt'; control points are .csv or .gsi",
                  LoadComplaint("", "control_points_test.tmp.txt").c_str());
}

// The digits that it is to bring back are not missing there; whoever gives it takes the file for another.
TEST(ControlPoints, RefusesAnOffsetForGsi8WhereThereIsNone) {
  const std::string gsi = "control_points_test.tmp.gsi";
  const auto complaint = [](const std::string& text, const std::string& path) {
    std::ofstream(path, std::ios::binary) << text;
    const auto file = LoadControlPoints(path, Eigen::Vector3d(1, 2, 3));
    std::remove(path.c_str());
    return file ? "" : file.error().Line();
  };
  STRCMP_EQUAL("", complaint("11....+00000473 81..00+65385748\n", gsi).c_str());
  STRCMP_EQUAL(("--gsi8-offset-m: is given, but " + gsi + " holds no GSI-8").c_str(),
               complaint("*110001+0000000000009001 81..10+0000000698460332\n", gsi).c_str());
  STRCMP_CONTAINS("holds no GSI-8", complaint(kHeader + "a,1,2,3,\n", kPath).c_str());
}

TEST(ControlPoints, RefusesWhatIsNoTextOrHoldsNothing) {
  STRCMP_CONTAINS("holds no point", LoadComplaint(kHeader).c_str());
  STRCMP_CONTAINS("holds no point", LoadComplaint("").c_str());
  STRCMP_CONTAINS("control_points_test.tmp.csv:2: is no text: it holds the control character 27",
                  LoadComplaint(kHeader + "a\x1b[2J,1,2,3,\n").c_str());
  STRCMP_CONTAINS("control character 13", LoadComplaint("name\ra\rb").c_str());
  STRCMP_CONTAINS("cannot be read", LoadControlPoints("no_such.csv", std::nullopt).error().Line().c_str());
}
