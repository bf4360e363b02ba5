#include "firmware/config/box_config.h"

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

using adit::config::BoxConfig;
using adit::config::LoadBoxConfig;

namespace {

const char* const kPath = "box_config_test.tmp.yaml";
const char* const kGood =
    "rig: rig.yaml\nmodels: [a.yaml, b.yaml]\ncameras:\n  left: {device: 10.0.0.1}\n  right: {device: "
    "10.0.0.2}\n";

/// What LoadBoxConfig says of `text`: "" if nothing is wrong.
std::string Complaint(const std::string& text) {
  std::ofstream(kPath) << text;
  const auto config = LoadBoxConfig(kPath);
  return config ? "" : config.error().Line();
}

void CheckNames(const std::string& complaint, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) STRCMP_CONTAINS(part.c_str(), complaint.c_str());
  CHECK(complaint.find('\n') == std::string::npos);
}

}  // namespace

TEST_GROUP(BoxConfig){void teardown() override{std::remove(kPath);
}
}
;

TEST(BoxConfig, ReadsAMinimalFileAndFillsInDefaults) {
  std::ofstream(kPath) << kGood;
  const auto config = LoadBoxConfig(kPath);
  CHECK(!!config);
  STRCMP_EQUAL("10.0.0.2", config->cameras.right.device.c_str());
  DOUBLES_EQUAL(60, config->cameras.rate_hz, 0);
  LONGS_EQUAL(2, config->models.size());
  LONGS_EQUAL(0x20, config->publish.can.node);
  CHECK(config->crc32 != 0);
}

TEST(BoxConfig, WhatItShowsReadsBackToTheSame) {
  std::ofstream(kPath)
      << kGood << "georeference: g.yaml\nhealth_report: h.yaml\n"
      << "publish: {site_origin_m: [546123, 178456, 400], can: {driver: candump, log: c.log}}\n";
  const auto first = LoadBoxConfig(kPath);
  CHECK(!!first);
  const std::string shown = adit::config::FormatBoxConfig(*first);
  STRCMP_EQUAL("", Complaint(shown).c_str());
  const auto second = LoadBoxConfig(kPath);
  STRCMP_EQUAL(shown.c_str(), adit::config::FormatBoxConfig(*second).c_str());
  STRCMP_CONTAINS("546123", shown.c_str());
  STRCMP_EQUAL("g.yaml", second->georeference.c_str());
  STRCMP_EQUAL("h.yaml", second->health_report.c_str());
}

TEST(BoxConfig, EveryKeyShownIsInTheSchemaWithItsMeaning) {
  const std::string schema = adit::config::FormatBoxSchema();
  for (const char* key :
       {"exposure_us", "sigma_limit_mm", "cycle_ms", "track_log", "serial", "georeference"}) {
    STRCMP_CONTAINS(key, schema.c_str());
  }
  STRCMP_CONTAINS("(20 to 1000 ms)", schema.c_str());
}

TEST(BoxConfig, NamesFileKeyValueAndWhatIsAllowed) {
  CheckNames(Complaint("models: [a]\n"), {kPath, "rig", "is missing"});
  CheckNames(Complaint("rig: r\n"), {"models", "missing"});
  CheckNames(Complaint(std::string(kGood) + "exposre_us: 3\n"),
             {kPath, "exposre_us", "not known", "track_log"});
  CheckNames(Complaint(std::string(kGood) + "publish: {can: {nod: 3}}\n"), {"publish.can.nod", "not known"});
  CheckNames(Complaint(std::string(kGood) + "publish: {can: {node: 200}}\n"),
             {"publish.can.node", "200", "1 to 126"});
  CheckNames(Complaint(std::string(kGood) + "publish: {can: {driver: canopen}}\n"), {"canopen", "socketcan"});
  CheckNames(Complaint(std::string(kGood) + "publish: {can: {driver: candump}}\n"), {"publish.can", "log"});
  CheckNames(Complaint(std::string(kGood) + "publish: {site_origin_m: [1.5, 0, 0]}\n"),
             {"site_origin_m", "whole"});
  CheckNames(Complaint(std::string(kGood) + "watch: {lights_m: [1, 2, 30, 4]}\n"),
             {"watch.lights_m", "4 numbers"});
  CheckNames(Complaint(std::string(kGood) + "watch: {lights_m: [1, 2, 30, 4, 5, 60]}\n"),
             {"watch.lights_m", "three lights"});
  CheckNames(Complaint("rig: [\n"), {kPath, "not YAML"});
  CheckNames(Complaint("rig: r\nmodels: [a]\ncameras: {left: {device: x}, right: {device: x}}\n"),
             {"x", "both"});
  CheckNames(Complaint("rig: r\nmodels: [a]\ncameras: {driver: recording}\n"), {"cameras", "recording"});
}
