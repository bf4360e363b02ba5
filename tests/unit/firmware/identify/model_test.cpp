#include "firmware/identify/model.h"

#include <cstdio>
#include <fstream>
#include <string>

#include <CppUTest/TestHarness.h>

using adit::identify::LoadModel;
using adit::identify::LoadTarget;

namespace {

const char* const kPath = "model_test.tmp.yaml";
const std::string kTarget = "name: one\nleds_m: [0, 0.25, 0.65, 1.5]\nepicenter_m: -0.4\n";
const std::string kRanges = "p2_range: [2.2, 2.3]\ncollinearity_max: 0.01\nlength_range_px: [20, 600]\n";

/// What LoadModel says of `text`: "" if nothing is wrong.
std::string Complaint(const std::string& text) {
  std::ofstream(kPath) << text;
  const auto model = LoadModel(kPath);
  return model ? "" : model.error().Line();
}

void CheckNames(const std::string& complaint, const char* key, const char* detail) {
  STRCMP_CONTAINS(kPath, complaint.c_str());
  STRCMP_CONTAINS(key, complaint.c_str());
  STRCMP_CONTAINS(detail, complaint.c_str());
  CHECK(complaint.find('\n') == std::string::npos);
}

}  // namespace

TEST_GROUP(Model){void teardown() override{std::remove(kPath);
}
}
;

TEST(Model, WhatIsWrittenReadsBackToTheSame) {
  STRCMP_EQUAL("", Complaint(kTarget + kRanges).c_str());
  const auto first = LoadModel(kPath);
  CHECK(!!first);
  DOUBLES_EQUAL(0.65, first->target.leds_m[2], 0);
  DOUBLES_EQUAL(-0.4, first->target.epicenter_m, 0);
  STRCMP_EQUAL("", Complaint(adit::identify::FormatModel(*first)).c_str());
  const auto second = LoadModel(kPath);
  STRCMP_EQUAL(adit::identify::FormatModel(*first).c_str(), adit::identify::FormatModel(*second).c_str());
}

TEST(Model, RefusesOtherThanFourLeds) {
  CheckNames(Complaint("name: x\nleds_m: [0, 0.25, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m", "4");
  CheckNames(Complaint("name: x\nleds_m: [0, 0.2, 0.5, 0.9, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m",
             "4");
}

TEST(Model, RefusesLedsThatDoNotAscendFromZero) {
  CheckNames(Complaint("name: x\nleds_m: [0.1, 0.25, 0.65, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m",
             "0.1");
  CheckNames(Complaint("name: x\nleds_m: [0, 0.65, 0.25, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m",
             "ascend");
  CheckNames(Complaint("name: x\nleds_m: [0, 0.005, 0.65, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m",
             "0.010");
}

TEST(Model, RefusesALayoutThatReadsTheSameFromBothEnds) {
  CheckNames(Complaint("name: x\nleds_m: [0, 0.5, 1.0, 1.5]\nepicenter_m: 0\n" + kRanges), "leds_m",
             "direction");
}

TEST(Model, RefusesRangesThatAreNone) {
  CheckNames(
      Complaint(kTarget + "p2_range: [2.3, 2.2]\ncollinearity_max: 0.01\nlength_range_px: [20, 600]\n"),
      "p2_range", "ascend");
  CheckNames(
      Complaint(kTarget + "p2_range: [1.9, 2.2]\ncollinearity_max: 0.01\nlength_range_px: [20, 600]\n"),
      "p2_range", "1.9");
  CheckNames(Complaint(kTarget + "p2_range: [2.1, 2.2]\ncollinearity_max: 0.01\nlength_range_px: [70, 60]\n"),
             "length_range_px", "ascend");
}

TEST(Model, RefusesUnknownKeysAndMissingFiles) {
  CheckNames(Complaint(kTarget + kRanges + "epicentre_m: 3\n"), "epicentre_m", "not known");
  CheckNames(Complaint(kTarget), "p2_range", "missing");
  CHECK_FALSE(LoadTarget("no_such_file.yaml"));
}
