#include "drivers/linux/realtime.h"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace adit::linux {
namespace {

Grant Answer(int error, const std::string& wish) {
  if (error == 0) return {true, wish};
  return {false, "no " + wish + ": " + std::strerror(error)};
}

/// Whether this process may lock memory without limit (CAP_IPC_LOCK, or no RLIMIT_MEMLOCK).
bool LocksWithoutLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {};
  return syscall(SYS_capget, &header, sets) == 0 && (sets[0].effective & (1U << CAP_IPC_LOCK)) != 0;
}

}  // namespace

Grant LockMemory() {
  const bool free = LocksWithoutLimit();
  const int flags = free ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT;
  return Answer(mlockall(flags) == 0 ? 0 : errno, free ? "memory locked" : "memory locked (present only)");
}

Grant SetRealtimePriority(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  return Answer(pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted),
                "real-time priority " + std::to_string(priority));
}

Grant PinToCpu(int cpu) {
  const std::string wish = "affinity to CPU " + std::to_string(cpu);
  if (cpu < 0 || cpu >= CPU_SETSIZE) return Answer(EINVAL, wish);
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  return Answer(pthread_setaffinity_np(pthread_self(), sizeof set, &set), wish);
}

Grant NameThread(const std::string& name) {
  constexpr std::size_t kKernelKeeps = 15;  // TASK_COMM_LEN - 1
  return Answer(pthread_setname_np(pthread_self(), name.substr(0, kKernelKeeps).c_str()),
                "thread name " + name);
}

}  // namespace adit::linux
