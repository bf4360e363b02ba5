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
    return base::Error{base::ErrorCode::kUnavailable, path,
                       std::string("cannot be written: ") + std::strerror(errno)};
  }
  file_ << pipeline::TrackHeader() << "\n" << std::flush;
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

void TrackLog::Drain(LogConveyor& records) {
  while (FixRecord* const record = records.Pop()) {
    for (const georef::GeoFix& fix : record->fixes.targets) {
      file_ << pipeline::FormatTrackRow(pipeline::TrackRowOf(fix, names_[fix.state.points.target])) << "\n";
    }
    records.GiveBack(record);
  }
  file_ << std::flush;  // whole lines only, so that a reader may follow
}

}  // namespace adit::app
