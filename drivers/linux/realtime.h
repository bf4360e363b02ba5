// What a thread of the box asks of the system, and whether it was granted.
#pragma once

#include <string>

namespace adit::linux {

/// The answer, worded for the health report: "memory locked", "no real-time priority 50: Operation not
/// permitted". A box that is refused still works, later at times.
struct Grant {
  bool granted = false;
  std::string text;
};

/// Keeps all memory of this process in RAM, present and future, so that the hot path meets no page fault.
/// Without the privilege only the present memory is locked: a limit on future memory would make later
/// allocations fail instead.
Grant LockMemory();

/// SCHED_FIFO at `priority` (1 to 99) for the calling thread.
Grant SetRealtimePriority(int priority);

/// Keeps the calling thread on `cpu`, counted from 0.
Grant PinToCpu(int cpu);

/// Names the calling thread for ps and top; the kernel keeps 15 characters.
Grant NameThread(const std::string& name);

}  // namespace adit::linux
