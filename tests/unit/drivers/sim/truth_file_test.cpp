#include "drivers/sim/truth_file.h"

#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::sim::FormatTruth;
using adit::sim::ReadTruth;
using adit::sim::TruthHeader;
using adit::sim::TruthRow;
using adit::sim::TruthRows;
using adit::sim::World;
using adit::tests::kBarKeys;
using adit::tests::kSmallRig;
using adit::tests::SceneOf;
using adit::tests::ScratchFolder;

namespace {

const std::string kRow =
    "1700000000000500000,3,bar,0.1,0.2,20,1,0,0,0.1,0.2,20,0.3,0.2,20,0.6,0.2,20,1.1,0.2,20,4\n";

std::string Replaced(const std::string& from, const std::string& to) {
  std::string row = kRow;
  return row.replace(row.find(from), from.size(), to);
}

}  // namespace

TEST_GROUP(TruthFile){};

TEST(TruthFile, HasTheDocumentedHeader) {
  STRCMP_EQUAL(
      "timestamp_ns,trigger,target,x_m,y_m,z_m,dx,dy,dz,led1_x_m,led1_y_m,led1_z_m,led2_x_m,led2_y_m,led2_z_"
      "m,"
      "led3_x_m,led3_y_m,led3_z_m,led4_x_m,led4_y_m,led4_z_m,visible\n",
      TruthHeader().c_str());
}

TEST(TruthFile, ReturnsWhatWasWritten) {
  const World world(SceneOf(kSmallRig + "targets: [{" + kBarKeys +
                            ", epicenter_m: 3, at_m: [0.1, -0.2, 20], direction: [0.6, 0, 0.8]}]\n"));
  const ScratchFolder scratch;
  const auto rows = TruthRows(world, 7);
  const auto read = ReadTruth(scratch.Write("truth.csv", TruthHeader() + FormatTruth(rows)));
  CHECK_TRUE(static_cast<bool>(read));
  LONGS_EQUAL(1, read->size());
  const TruthRow& row = read->front();
  LONGLONGS_EQUAL(world.MidExposureNs(7), row.mid_exposure_ns);
  LONGS_EQUAL(7, row.trigger);
  STRCMP_EQUAL("bar", row.target.c_str());
  DOUBLES_EQUAL(0, (row.epicenter_m - Eigen::Vector3d(1.9, -0.2, 22.4)).norm(), 1e-7);
  DOUBLES_EQUAL(0, (row.direction - Eigen::Vector3d(0.6, 0, 0.8)).norm(), 1e-7);
  DOUBLES_EQUAL(0, (row.leds_m[3] - Eigen::Vector3d(1.3, -0.2, 21.6)).norm(), 1e-7);
  LONGS_EQUAL(rows.front().visible, row.visible);
}

TEST(TruthFile, ReadsCrLfAndNoRowsAtAll) {
  const ScratchFolder scratch;
  std::string text;
  for (const char c : TruthHeader() + kRow) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  LONGS_EQUAL(1, ReadTruth(scratch.Write("crlf.csv", text))->size());
  LONGS_EQUAL(0, ReadTruth(scratch.Write("none.csv", TruthHeader()))->size());
}

TEST(TruthFile, RefusesWithFileAndLine) {
  const std::pair<std::string, const char*> cases[] = {
      {Replaced(",4\n", "\n"), "truth.csv:2: has 21 cells; it must have 22"},
      {Replaced(",4\n", ",4,5\n"), "truth.csv:2: has 23 cells"},
      {Replaced(",4\n", ",5\n"), "truth.csv:2: has 5 visible LEDs"},
      {Replaced(",4\n", ",-1\n"), "truth.csv:2: has -1 visible LEDs"},
      {Replaced(",4\n", ",4.0\n"), "truth.csv:2: has '4.0' in cell 22"},
      {Replaced("0.2,20,1,0,0", "nan,20,1,0,0"), "truth.csv:2: has 'nan' in cell 5"},
      {Replaced("0.2,20,1,0,0", ",20,1,0,0"), "truth.csv:2: has '' in cell 5"},
      {Replaced("20,1,0,0", "20,2,0,0"), "truth.csv:2: has a direction of length 2"},
      {Replaced(",bar,", ",,"), "truth.csv:2: names no target"},
      {Replaced("1700000000000500000", "1.7e18"), "truth.csv:2: has '1.7e18' in cell 1"},
      {Replaced("1700000000000500000", "99999999999999999999"),
       "truth.csv:2: has '99999999999999999999' in cell 1"},
      {kRow + Replaced("1700000000000500000", "1600000000000500000"),
       "truth.csv:3: has the time 1600000000000500000"},
  };
  const ScratchFolder scratch;
  for (const auto& [rows, said] : cases) {
    const auto read = ReadTruth(scratch.Write("truth.csv", TruthHeader() + rows));
    CHECK_FALSE(static_cast<bool>(read));
    STRCMP_CONTAINS(said, read.error().Line().c_str());
  }
  STRCMP_CONTAINS("truth.csv:1: is not the header",
                  ReadTruth(scratch.Write("truth.csv", kRow)).error().Line().c_str());
  STRCMP_CONTAINS("truth.csv:1: is not the header",
                  ReadTruth(scratch.Write("truth.csv", "")).error().Line().c_str());
  CHECK_FALSE(static_cast<bool>(ReadTruth(scratch / "nowhere.csv")));
}
