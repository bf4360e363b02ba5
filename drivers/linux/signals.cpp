#include "drivers/linux/signals.h"

#include <poll.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include "drivers/linux/system_clock.h"
#include "firmware/base/require.h"

namespace adit::linux {

StopSignals::StopSignals() {
  sigset_t stops;
  sigemptyset(&stops);
  sigaddset(&stops, SIGINT);
  sigaddset(&stops, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stops, &previous_);
  descriptor_ = FileDescriptor(signalfd(-1, &stops, SFD_CLOEXEC | SFD_NONBLOCK));
  ADIT_REQUIRE(descriptor_);
}

StopSignals::~StopSignals() {
  // A signal that arrived and was never looked at would strike as soon as the mask falls.
  WaitFor(0);
  pthread_sigmask(SIG_SETMASK, &previous_, nullptr);
}

bool StopSignals::WaitFor(base::DurationNs timeout_ns) {
  const std::int64_t deadline_ns = MonotonicNs() + timeout_ns;
  std::int64_t left_ns = timeout_ns;
  do {
    pollfd wait{descriptor_.Get(), POLLIN, 0};
    timespec timeout{};
    if (!stopped_ && left_ns > 0) {
      timeout.tv_sec = left_ns / base::kNsPerS;
      timeout.tv_nsec = left_ns % base::kNsPerS;
    }
    ppoll(&wait, 1, &timeout, nullptr);
    // Takes all of them: Ctrl-C strikes the whole process group and the parent often sends a second one.
    signalfd_siginfo taken{};
    while (read(descriptor_.Get(), &taken, sizeof taken) == sizeof taken) stopped_ = true;
    left_ns = deadline_ns - MonotonicNs();
  } while (!stopped_ && left_ns > 0);
  return stopped_;
}

}  // namespace adit::linux
