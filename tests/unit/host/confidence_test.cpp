// Limits against printed tables.
#include "host/confidence.h"

#include <CppUTest/TestHarness.h>

using adit::host::NormalisedErrorLimits;
using adit::host::PoissonUpper95;

TEST_GROUP(Confidence){};

// One-sided limits of Garwood 1936, as tables of rare events print them.
TEST(Confidence, PoissonLimitsAreThoseOfTheTables) {
  DOUBLES_EQUAL(2.996, PoissonUpper95(0), 0.001);
  DOUBLES_EQUAL(4.744, PoissonUpper95(1), 0.001);
  DOUBLES_EQUAL(7.754, PoissonUpper95(3), 0.001);
  DOUBLES_EQUAL(16.962, PoissonUpper95(10), 0.001);
}

// Quantiles 2.5 % and 97.5 % of chi-square: 3.247 and 20.483 of 10, 74.222 and 129.561 of 100.
TEST(Confidence, ChiSquareLimitsAreThoseOfTheTables) {
  DOUBLES_EQUAL(3.247 / 10, NormalisedErrorLimits(10).low, 0.003);
  DOUBLES_EQUAL(20.483 / 10, NormalisedErrorLimits(10).high, 0.003);
  DOUBLES_EQUAL(74.222 / 100, NormalisedErrorLimits(100).low, 0.0005);
  DOUBLES_EQUAL(129.561 / 100, NormalisedErrorLimits(100).high, 0.0005);
}
