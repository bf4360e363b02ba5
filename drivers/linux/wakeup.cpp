#include "drivers/linux/wakeup.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "drivers/linux/system_clock.h"

namespace adit::linux {
namespace {

// The kernel compares the very bytes of the atomic.
static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

void FutexWait(std::atomic<std::uint32_t>& word, std::uint32_t expected, std::int64_t timeout_ns) {
  timespec timeout{};
  timeout.tv_sec = timeout_ns / base::kNsPerS;
  timeout.tv_nsec = timeout_ns % base::kNsPerS;
  // Woken, changed meanwhile, interrupted, timed out: the caller looks at the word in every case.
  syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), FUTEX_WAIT_PRIVATE, expected, &timeout, nullptr,
          0);
}

void FutexWake(std::atomic<std::uint32_t>& word) {
  syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

}  // namespace

void Wakeup::Signal() {
  // release: the work stands before the signal. An exchange, not a store: it continues the release sequence
  // of an earlier signal that it overwrites, so the waiter sees the work of both signallers.
  if (state_.exchange(kSignalled, std::memory_order_release) == kSleeping) FutexWake(state_);
}

bool Wakeup::WaitFor(base::DurationNs timeout_ns) {
  // acquire: pairs with the release in Signal, here and below; the work is visible.
  if (state_.exchange(kIdle, std::memory_order_acquire) == kSignalled) return true;
  if (timeout_ns <= 0) return false;
  const std::int64_t deadline_ns = MonotonicNs() + timeout_ns;
  for (std::int64_t left_ns = timeout_ns; left_ns > 0; left_ns = deadline_ns - MonotonicNs()) {
    std::uint32_t expected = kIdle;
    // relaxed: says only that somebody sleeps; on failure the exchange below acquires.
    if (state_.compare_exchange_strong(expected, kSleeping, std::memory_order_relaxed,
                                       std::memory_order_relaxed)) {
      // A Signal between the exchange above and the kernel's look changes the word: the wait returns at once.
      FutexWait(state_, kSleeping, left_ns);
    }
    if (state_.exchange(kIdle, std::memory_order_acquire) == kSignalled) return true;
  }
  return false;
}

}  // namespace adit::linux
