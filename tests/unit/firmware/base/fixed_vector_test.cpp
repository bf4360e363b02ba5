#include "firmware/base/fixed_vector.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <numeric>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::FixedVector;

TEST_GROUP(FixedVector){};

TEST(FixedVector, TakesItsCapacityAndDeclinesTheNext) {
  FixedVector<int, 3> vector;
  CHECK_TRUE(vector.empty());
  for (const int value : {4, 5, 6}) CHECK_TRUE(vector.push_back(value));
  CHECK_TRUE(vector.Full());
  CHECK_FALSE(vector.push_back(7));
  LONGS_EQUAL(3, vector.size());
  LONGS_EQUAL(6, vector.back());
  LONGS_EQUAL(15, std::accumulate(vector.begin(), vector.end(), 0));
}

TEST(FixedVector, IsEmptyAfterClearAndTakesAllAgain) {
  FixedVector<int, 2> vector;
  vector.push_back(1);
  vector.push_back(2);
  vector.clear();
  CHECK_TRUE(vector.empty());
  CHECK_TRUE(vector.begin() == vector.end());
  CHECK_TRUE(vector.push_back(9));
  LONGS_EQUAL(9, vector[0]);
}

TEST(FixedVector, ShortensToWhatIsAsked) {
  FixedVector<int, 4> vector;
  for (const int value : {1, 2, 3}) vector.push_back(value);
  vector.Truncate(3);
  LONGS_EQUAL(3, vector.size());
  vector.Truncate(1);
  LONGS_EQUAL(1, vector.back());
}

TEST(FixedVector, AbortsWhenTruncatedToMoreThanItHolds) {
  const pid_t child = fork();
  if (child == 0) {
    close(STDERR_FILENO);
    FixedVector<int, 4> vector;
    vector.Truncate(1);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

TEST(FixedVector, AllocatesNothing) {
  const std::uint64_t before = adit::support::AllocationCount();
  FixedVector<double, 100> vector;
  while (vector.push_back(1.5)) {
  }
  const FixedVector<double, 100> copy = vector;
  LONGS_EQUAL(before, adit::support::AllocationCount());
  LONGS_EQUAL(100, copy.size());
}
