#include "firmware/base/result.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>

#include <CppUTest/TestHarness.h>

using adit::base::Error;
using adit::base::ErrorCode;
using adit::base::Result;

namespace {

/// The signal that ends a child process in which `work` runs; 0 if it returns.
template <class Work>
int EndsBy(Work work) {
  const pid_t child = fork();
  if (child == 0) {
    close(STDERR_FILENO);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_GROUP(Result){};

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> good = 5;
  const Result<int> bad = Error{ErrorCode::kFailed, "w", "d"};
  CHECK_TRUE(static_cast<bool>(good));
  LONGS_EQUAL(5, *good);
  CHECK_FALSE(static_cast<bool>(bad));
  STRCMP_EQUAL("w: d", bad.error().Line().c_str());
}

TEST(Result, MovesAValueThatCannotBeCopied) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> taken = *std::move(result);
  LONGS_EQUAL(7, *taken);
}

TEST(Result, OfNothingIsDoneUnlessToldOtherwise) {
  CHECK_TRUE(static_cast<bool>(Result<void>()));
  CHECK_FALSE(static_cast<bool>(Result<void>(Error{})));
}

TEST(Result, LeavesOutAnEmptyPlace) {
  STRCMP_EQUAL("d", (Error{ErrorCode::kFailed, "", "d"}).Line().c_str());
}

TEST(Result, ExitsWithTwoForWrongUseAndOneForFailedWork) {
  for (const ErrorCode code : {ErrorCode::kUsage, ErrorCode::kMalformed, ErrorCode::kOutOfRange})
    LONGS_EQUAL(2, (Error{code, "", ""}).ExitCode());
  for (const ErrorCode code : {ErrorCode::kNotFound, ErrorCode::kUnavailable, ErrorCode::kFailed})
    LONGS_EQUAL(1, (Error{code, "", ""}).ExitCode());
}

TEST(Result, AbortsWhenTheWrongSideIsAskedFor) {
  LONGS_EQUAL(SIGABRT, EndsBy([] { (void)Result<int>(Error{}).value(); }));
  LONGS_EQUAL(SIGABRT, EndsBy([] { (void)Result<int>(1).error(); }));
  LONGS_EQUAL(SIGABRT, EndsBy([] { (void)Result<void>().error(); }));
  LONGS_EQUAL(0, EndsBy([] { (void)Result<int>(1).value(); }));
}
