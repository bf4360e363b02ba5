#include "host/suite_report.h"

#include <cmath>

#include "host/crew.h"

#include <CppUTest/TestHarness.h>

using adit::host::SuiteReport;

TEST_GROUP(SuiteReport){};

TEST(SuiteReport, HoldsWhenEveryBarHolds) {
  SuiteReport report;
  report.Inform("told", 99);
  report.AtMost("swaps", 0, 0);
  report.AtLeast("found", 99.9, 99.9, "%");
  CHECK(report.Holds());
  report.AtMost("spread", 1.16, 1.15);
  CHECK_FALSE(report.Holds());
}

TEST(SuiteReport, WhatWasNotMeasuredHoldsNoBar) {
  SuiteReport report;
  report.AtMost("spread", NAN, 1);
  CHECK_FALSE(report.Holds());
  STRCMP_CONTAINS("MISSED", adit::host::FormatSuiteTable(report).c_str());
  STRCMP_CONTAINS("\"value\": null", adit::host::FormatSuiteJson({report}, "underground", 1).c_str());
}

TEST(SuiteReport, ItsPageNamesTheBarsThatAreMissed) {
  SuiteReport report;
  report.name = "drive";
  report.AtMost("lost", 3, 1, "", 0);
  report.AtLeast("found", 99.9, 99, "%", 1);
  const std::string html = adit::host::MakeSuitePage({report}, "suite underground", "No tunnel.").Html();
  for (const char* part : {"drive: lost", "99.9", "&gt;= 99.0", "No tunnel."})
    STRCMP_CONTAINS(part, html.c_str());
}

TEST(SuiteReport, WorkInParallelKeepsTheOrder) {
  const auto squares = [](std::size_t i) { return i * i; };
  const auto alone = adit::host::WorkInParallel<std::size_t>("squares", 1000, squares, 1);
  const auto together = adit::host::WorkInParallel<std::size_t>("squares", 1000, squares, 8);
  LONGS_EQUAL(1000, together.size());
  LONGS_EQUAL(999 * 999, together[999]);
  CHECK(alone == together);
}
