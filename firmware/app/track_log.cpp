#include "firmware/app/track_log.h"

#include <cerrno>
#include <cstring>

#include "firmware/pipeline/track_row.h"

namespace adit::app {
namespace {

constexpr base::DurationNs kWaitRecordNs = 100 * base::kNsPerMs;  // bounded, so that Stop always ends

}  // namespace

base::Result<void> TrackLog::Open(const std::string& path, std::vector<std::string> target_names) {
  file_.open(path, std::ios::trunc);
  if (!file_) {
    return base::Error{base::ErrorCode::kUnavailable, path, std::string("cannot be written: ") + std::strerror(errno)};
  }
  names_ = std::move(target_names);
  return {};
}

TrackLog::~TrackLog() { Stop(); }

void TrackLog::Start(LogConveyor& records) {
  thread_ = std::thread([this, &records] {
    board::PrepareThread("track-log", 0, -1);
    Run(records);
  });
}

void TrackLog::Stop() {
  // relaxed: looked at after every wait; nothing is published through it.
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
  if (thread_.joinable()) thread_.join();
}

void TrackLog::Run(LogConveyor& records) {
  while (!stop_.load(std::memory_order_relaxed)) {
    wake_.WaitFor(kWaitRecordNs);
    Drain(records);
  }
  Drain(records);
}

}  // namespace adit::app
