#include "drivers/linux/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <fstream>
#include <thread>

#include "drivers/linux/system_clock.h"

#include <CppUTest/TestHarness.h>

using namespace adit::linux;

namespace {

/// Runs `work` in a thread of its own, so that this program keeps its priority and CPUs.
template <class Work>
void InThread(Work work) {
  std::thread(work).join();
}

}  // namespace

TEST_GROUP(Realtime){};

TEST(Realtime, PinsAThreadToACpuOrSaysWhyNot) {
  Grant grant, impossible;
  int cpu = -1;
  InThread([&] {
    grant = PinToCpu(0);
    cpu = sched_getcpu();
    impossible = PinToCpu(-1);
  });
  CHECK_TRUE(grant.granted == (grant.text == "affinity to CPU 0"));
  if (grant.granted) LONGS_EQUAL(0, cpu);
  CHECK_FALSE(impossible.granted);
  STRCMP_EQUAL("no affinity to CPU -1: Invalid argument", impossible.text.c_str());
}

TEST(Realtime, RefusesACpuThatDoesNotExist) {
  Grant last, beyond;
  InThread([&] {
    last = PinToCpu(CPU_SETSIZE - 1);
    beyond = PinToCpu(CPU_SETSIZE);
  });
  CHECK_FALSE(last.granted);
  CHECK_FALSE(beyond.granted);
}

TEST(Realtime, SetsThePriorityExactlyWhenItSaysSo) {
  Grant grant;
  int policy = -1;
  sched_param now{};
  InThread([&] {
    grant = SetRealtimePriority(10);
    pthread_getschedparam(pthread_self(), &policy, &now);
  });
  CHECK_EQUAL(grant.granted, policy == SCHED_FIFO && now.sched_priority == 10);
  STRCMP_CONTAINS("real-time priority 10", grant.text.c_str());
  CHECK_EQUAL(grant.granted, grant.text.rfind("no ", 0) != 0);
}

TEST(Realtime, RefusesAPriorityThatDoesNotExist) {
  Grant grant;
  InThread([&] { grant = SetRealtimePriority(100); });
  CHECK_FALSE(grant.granted);
  STRCMP_EQUAL("no real-time priority 100: Invalid argument", grant.text.c_str());
}

TEST(Realtime, CutsAThreadNameToWhatTheKernelKeeps) {
  char name[16] = "";
  Grant grant;
  InThread([&] {
    grant = NameThread("detect-left-and-more");
    pthread_getname_np(pthread_self(), name, sizeof name);
  });
  CHECK_TRUE(grant.granted);
  STRCMP_EQUAL("detect-left-and", name);
}

TEST(Realtime, LocksMemoryExactlyWhenItSaysSo) {
  const Grant grant = LockMemory();
  std::ifstream status("/proc/self/status");
  bool locked = false;
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmLck:", 0) == 0) locked = line.find_first_of("123456789") != std::string::npos;
  }
  munlockall();
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  // The sanitizers make mlockall do nothing and say yes: their shadow memory is larger than any RAM.
  locked = true;
#endif
  CHECK_EQUAL(grant.granted, locked);
  STRCMP_CONTAINS("memory locked", grant.text.c_str());
}

TEST(Realtime, ReadsTheSystemsTwoClocks) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t difference_ns = SystemClock().Now() - (now.tv_sec * adit::base::kNsPerS + now.tv_nsec);
  CHECK_TRUE(difference_ns >= 0 && difference_ns < 10 * adit::base::kNsPerS);
  const std::int64_t first_ns = MonotonicNs();
  CHECK_TRUE(MonotonicNs() >= first_ns);
}
