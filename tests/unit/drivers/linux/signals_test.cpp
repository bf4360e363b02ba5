#include "drivers/linux/signals.h"

#include <poll.h>
#include <unistd.h>

#include <thread>

#include "drivers/linux/system_clock.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::linux::MonotonicNs;
using adit::linux::StopSignals;

TEST_GROUP(StopSignals){};

TEST(StopSignals, KeepsTheFirstSignalForGood) {
  StopSignals stop;
  CHECK_FALSE(stop.WaitFor(0));
  kill(getpid(), SIGTERM);
  CHECK_TRUE(stop.WaitFor(kNsPerS));
  CHECK_TRUE(stop.WaitFor(0));
}

TEST(StopSignals, SurvivesSeveralOfBothKinds) {
  StopSignals stop;
  for (int i = 0; i < 3; ++i) {
    kill(getpid(), SIGINT);
    kill(getpid(), SIGTERM);
  }
  CHECK_TRUE(stop.WaitFor(kNsPerS));
}

TEST(StopSignals, WakesAWaitLongBeforeItsTimeout) {
  StopSignals stop;
  std::thread killer([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(getpid(), SIGINT);
  });
  const std::int64_t start_ns = MonotonicNs();
  const bool stopped = stop.WaitFor(60 * kNsPerS);
  killer.join();
  CHECK_TRUE(stopped);
  CHECK_TRUE(MonotonicNs() - start_ns < 30 * kNsPerS);
}

TEST(StopSignals, WaitsAsLongAsAskedWithoutASignal) {
  StopSignals stop;
  const std::int64_t start_ns = MonotonicNs();
  CHECK_FALSE(stop.WaitFor(20 * kNsPerMs));
  CHECK_TRUE(MonotonicNs() - start_ns >= 20 * kNsPerMs);
}

TEST(StopSignals, ShowsTheSignalOnItsDescriptor) {
  StopSignals stop;
  pollfd wait{stop.Descriptor(), POLLIN, 0};
  LONGS_EQUAL(0, poll(&wait, 1, 0));
  kill(getpid(), SIGTERM);
  LONGS_EQUAL(1, poll(&wait, 1, 1000));
}

TEST(StopSignals, SwallowsASignalNobodyLookedAt) {
  {
    StopSignals stop;
    kill(getpid(), SIGTERM);
  }
  sigset_t pending;
  sigpending(&pending);
  LONGS_EQUAL(0, sigismember(&pending, SIGTERM));
}

TEST(StopSignals, RestoresTheMask) {
  sigset_t before, after;
  pthread_sigmask(SIG_SETMASK, nullptr, &before);
  { StopSignals stop; }
  pthread_sigmask(SIG_SETMASK, nullptr, &after);
  LONGS_EQUAL(sigismember(&before, SIGTERM), sigismember(&after, SIGTERM));
  LONGS_EQUAL(0, sigismember(&after, SIGTERM));
}
