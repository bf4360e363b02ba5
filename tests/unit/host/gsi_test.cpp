#include "host/gsi.h"

#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::ControlPoint;
using adit::host::ParseGsi;
using Eigen::Vector3d;

// Lines with known values: the parser test of Tachy2GIS_arch (Landesamt fuer Archaeologie Sachsen).
const std::string kMillimetres =
    "*11....+0000000000000473 21.022+0000000039809400 22.022+0000000010859950 31..00+0000000000000609 "
    "81..00+0000000565385748 82..00+0000005924615105 83..00+0000000000005224 87..10+0000000000000000 \r\n";
const std::string kTenthsOfMillimetres =
    "*110009+0000000000000031 21.324+0000000011604363 22.324+0000000011608245 31..06+0000000000033649 "
    "51....+000000000008+034 87..16+0000000000000000 81..06+0000000000046612 82..06-0000000000022604 "
    "83..06+0000000000000000\r\n";
const std::string kGsi8 = "11....+00000473 81..00+65385748 82..00+24615105 83..00+00005224\n";
// Three blocks of one point in a file of GeoEasy's samples; the last height has no value.
const std::string kRepeated =
    "*110001+0000000000009001 81..10+0000000698460332 82..10+0000000173419641 83..10-0000000000000092 \n"
    "*110021+0000000000009001 81..10+0000000698460333 82..10+0000000173419643 83..10+0000000000000600 \n"
    "*110024+0000000000009001 81..10+0000000698460332 82..10+0000000173419642 83..10+00000000000----- \n";

std::vector<ControlPoint> Points(const std::string& text) {
  const auto points = ParseGsi(text, "f.gsi", std::nullopt);
  if (!points) FAIL(points.error().Line().c_str());
  return *points;
}

void CheckRefused(const std::string& text, const std::vector<std::string>& parts) {
  const auto points = ParseGsi(text, "f.gsi", std::nullopt);
  CHECK_FALSE(!!points);
  const std::string line = points.error().Line();
  for (const std::string& part : parts) STRCMP_CONTAINS(part.c_str(), line.c_str());
  LONGS_EQUAL(2, points.error().ExitCode());
}

}  // namespace

TEST_GROUP(Gsi){};

TEST(Gsi, ReadsMillimetresAndTenths) {
  const auto points = Points(kMillimetres + kTenthsOfMillimetres);
  LONGS_EQUAL(2, points.size());
  STRCMP_EQUAL("473", points[0].name.c_str());
  LONGS_EQUAL(1, points[0].line);
  DOUBLES_EQUAL(565385.748, *points[0].enh[0].value_m, 0);
  DOUBLES_EQUAL(5924615.105, *points[0].enh[1].value_m, 0);
  DOUBLES_EQUAL(5.224, *points[0].enh[2].value_m, 0);
  STRCMP_EQUAL("31", points[1].name.c_str());
  LONGS_EQUAL(2, points[1].line);
  DOUBLES_EQUAL(4.6612, *points[1].enh[0].value_m, 0);
  DOUBLES_EQUAL(-2.2604, *points[1].enh[1].value_m, 0);
  DOUBLES_EQUAL(0, *points[1].enh[2].value_m, 0);
}

TEST(Gsi, KeepsRepeatedPointsApartAndTheMissingHeightMissing) {
  const auto points = Points(kRepeated);
  LONGS_EQUAL(3, points.size());
  DOUBLES_EQUAL(698460.332, *points[0].enh[0].value_m, 0);
  DOUBLES_EQUAL(173419.643, *points[1].enh[1].value_m, 0);
  DOUBLES_EQUAL(-0.092, *points[0].enh[2].value_m, 0);
  CHECK_FALSE(points[2].enh[2].value_m.has_value());
  STRCMP_EQUAL("83..10+00000000000-----", points[2].enh[2].word.c_str());
}

TEST(Gsi, PassesOverObservationsAndCodes) {
  LONGS_EQUAL(0, Points("*410004+0000000000000021 42....+000000000000BP04 43....+0000000000001538\n"
                        "*110015+000000000000BP03 21.322+0000000016901313 51..1.+00000008+0000000 "
                        "71....+00000000000-----\n\n")
                     .size());
}

TEST(Gsi, NamesAreNotFilledUp) {
  STRCMP_EQUAL("bar_a.3", Points("*110001+000000000bar_a.3 81..00+0000000000001000\n")[0].name.c_str());
  STRCMP_EQUAL("WALL 7", Points("*110001+          WALL 7 81..00+0000000000001000\n")[0].name.c_str());
  STRCMP_EQUAL("0", Points("*110001+0000000000000000 81..00+0000000000001000\n")[0].name.c_str());
}

TEST(Gsi, RefusesGsi8WithoutAConfirmedOffset) {
  CheckRefused(kGsi8, {"f.gsi:1", "81..00+65385748", "GSI-8", "--gsi8-offset-m"});
  const auto points = ParseGsi(kGsi8, "f.gsi", Vector3d(500000, 5900000, 0));
  CHECK_TRUE(!!points);
  DOUBLES_EQUAL(565385.748, *(*points)[0].enh[0].value_m, 1e-9);
  DOUBLES_EQUAL(5924615.105, *(*points)[0].enh[1].value_m, 1e-9);
}

TEST(Gsi, NamesFileLineAndWordOfWhatIsWrong) {
  CheckRefused("\n*110001+0000000000000473 81..01+0000000565385748\n",
               {"f.gsi:2", "81..01+0000000565385748", "unit 1", "0 (mm)"});
  CheckRefused("*110001+0000000000000473 81..00+00000005653857\n",
               {"f.gsi:1", "81..00+00000005653857", "GSI-16"});
  CheckRefused("*110001+0000000000000473 81..00+000000056538574X\n",
               {"81..00+000000056538574X", "whole number"});
  CheckRefused("*110001+0000000000000473 81..00 0000000565385748\n", {"is no word"});
  CheckRefused("*110001+0000000000000473 81..00+0000000565385748 81..00+0000000565385748\n", {"twice"});
  CheckRefused("*81..00+0000000565385748\n", {"no word 11"});
  CheckRefused("name,easting_m\n", {"f.gsi:1", "is no word of GSI-8"});
}
