#include "drivers/linux/wakeup.h"

#include <atomic>
#include <thread>
#include <vector>

#include "drivers/linux/system_clock.h"
#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::linux::MonotonicNs;
using adit::linux::Wakeup;

TEST_GROUP(Wakeup){};

TEST(Wakeup, KeepsASignalUntilItIsTakenOnce) {
  Wakeup wakeup;
  wakeup.Signal();
  CHECK_TRUE(wakeup.WaitFor(0));
  CHECK_FALSE(wakeup.WaitFor(0));
}

TEST(Wakeup, CoalescesSignals) {
  Wakeup wakeup;
  for (int i = 0; i < 3; ++i) wakeup.Signal();
  CHECK_TRUE(wakeup.WaitFor(0));
  CHECK_FALSE(wakeup.WaitFor(0));
}

TEST(Wakeup, WaitsAsLongAsAskedWithoutASignal) {
  Wakeup wakeup;
  const std::int64_t start_ns = MonotonicNs();
  CHECK_FALSE(wakeup.WaitFor(20 * kNsPerMs));
  CHECK_TRUE(MonotonicNs() - start_ns >= 20 * kNsPerMs);
}

TEST(Wakeup, DoesNotWaitForAPastTime) {
  Wakeup wakeup;
  CHECK_FALSE(wakeup.WaitFor(-kNsPerS));
  wakeup.Signal();
  CHECK_TRUE(wakeup.WaitFor(-kNsPerS));
}

TEST(Wakeup, WakesASleeperLongBeforeItsTimeout) {
  Wakeup wakeup;
  std::thread signaller([&wakeup] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    wakeup.Signal();
  });
  const std::int64_t start_ns = MonotonicNs();
  const bool woken = wakeup.WaitFor(60 * kNsPerS);
  signaller.join();
  CHECK_TRUE(woken);
  CHECK_TRUE(MonotonicNs() - start_ns < 30 * kNsPerS);
}

// Two signallers count plain, unsynchronised-looking work up behind the signal; a lost wake-up shows as a
// wait that runs into its timeout with work undone, a missing order as a data race under TSan.
TEST(Wakeup, LosesNoWorkBetweenTwoSignallersAndASleeper) {
  constexpr int kEach = 100000;
  Wakeup wakeup;
  std::atomic<int> work[2] = {0, 0};
  const auto produce = [&wakeup](std::atomic<int>& mine) {
    for (int i = 1; i <= kEach; ++i) {
      mine.store(i, std::memory_order_relaxed);  // ordered by the signal alone, which is what is tested
      wakeup.Signal();
    }
  };
  std::thread first(produce, std::ref(work[0])), second(produce, std::ref(work[1]));
  bool late = false;
  while (!late &&
         work[0].load(std::memory_order_relaxed) + work[1].load(std::memory_order_relaxed) < 2 * kEach) {
    late = !wakeup.WaitFor(20 * kNsPerS);
  }
  first.join();
  second.join();
  CHECK_FALSE(late);
}

TEST(Wakeup, HandsOverPlainMemory) {
  constexpr int kRounds = 20000;
  Wakeup there, back;
  int value = 0;  // no atomic: TSan sees a race unless the wakeups order it
  std::thread other([&] {
    for (int i = 0; i < kRounds; ++i) {
      while (!there.WaitFor(kNsPerS)) {
      }
      value += 1;
      back.Signal();
    }
  });
  bool right = true;
  for (int i = 0; i < kRounds; ++i) {
    value += 1;
    there.Signal();
    while (!back.WaitFor(kNsPerS)) {
    }
    right = right && value == 2 * (i + 1);
  }
  other.join();
  CHECK_TRUE(right);
}

TEST(Wakeup, AllocatesNothing) {
  Wakeup wakeup;
  const std::uint64_t before = adit::support::AllocationCount();
  wakeup.Signal();
  const bool taken = wakeup.WaitFor(kNsPerMs);
  const bool timed_out = !wakeup.WaitFor(kNsPerMs);
  LONGS_EQUAL(before, adit::support::AllocationCount());
  CHECK_TRUE(taken && timed_out);
}
