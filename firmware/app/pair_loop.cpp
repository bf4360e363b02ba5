#include "firmware/app/pair_loop.h"

#include <algorithm>

namespace adit::app {
namespace {

// Between two looks for frames that wait in vain; short beside the pairer's patience.
constexpr base::DurationNs kTickNs = 20 * base::kNsPerMs;

capture::PairerOptions PairerOptionsOf(base::DurationNs period_ns) {
  capture::PairerOptions options;
  options.period_ns = period_ns;
  return options;
}

/// Copies what is there; the rest of the storage stays as it was.
void CopyFixes(const georef::GeoFixSet& from, georef::GeoFixSet& to) {
  to.georeferenced = from.georeferenced;
  to.targets.clear();
  for (const georef::GeoFix& fix : from.targets) to.targets.push_back(fix);
}

}  // namespace

PairLoop::PairLoop(pipeline::Pipeline& pipeline, base::DurationNs period_ns, base::DurationNs exposure_ns)
    : pipeline_(pipeline),
      exposure_ns_(exposure_ns),
      pairer_(PairerOptionsOf(period_ns)),
      result_(std::make_unique<pipeline::PairResult>()) {}

PairLoop::~PairLoop() { Stop(); }

void PairLoop::Start(const ThreadOptions& options, const PairNeighbours& neighbours) {
  thread_ = std::thread([this, options, neighbours] {
    board::PrepareThread("pair", options.priority, options.cpu);
    Run(neighbours);
  });
}

void PairLoop::Stop() {
  // relaxed: looked at every tick; nothing is published through it.
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
  if (thread_.joinable()) thread_.join();
}

void PairLoop::Run(const PairNeighbours& neighbours) {
  while (!stop_.load(std::memory_order_relaxed)) {
    // Read before the last look into the lanes, or an end could overtake a blob set.
    const bool both_ended = neighbours.left.Ended() && neighbours.right.Ended();
    bool took = false;
    for (CameraLane* const lane : {&neighbours.left, &neighbours.right}) {
      took = Take(*lane) || took;
      while (const auto event = pairer_.Next(clock_.Now())) Handle(*event, neighbours);
    }
    if (took) continue;
    if (both_ended) break;
    wake_.WaitFor(kTickNs);
  }
  while (const auto event = pairer_.Flush()) Handle(*event, neighbours);
  health_.Store(counts_);
  // release: whoever sees the end also sees the last record.
  ended_.store(true, std::memory_order_release);
}

bool PairLoop::Take(CameraLane& lane) {
  detect::BlobSet* const blobs = lane.Pop();
  if (blobs == nullptr) return false;
  pairer_.Add(blobs->stamp, blobs);
  return true;
}

void PairLoop::Handle(const Event& event, const PairNeighbours& neighbours) {
  if (event.Paired()) {
    Locate(**event.left, **event.right, neighbours.log != nullptr);
    neighbours.publisher.Signal();
    if (neighbours.log != nullptr) neighbours.log->Signal();
  } else if (counts_.pairs > 0) {  // before the first pair, one camera waits for the other to start
    counts_.unpaired += 1;
  }
  if (event.left) neighbours.left.GiveBack(*event.left);
  if (event.right) neighbours.right.GiveBack(*event.right);
  health_.Store(counts_);
}

void PairLoop::Locate(const detect::BlobSet& left, const detect::BlobSet& right, bool with_log) {
  const std::int64_t start_ns = board::MonotonicNs();
  pipeline_.Locate(left, right, *result_);
  locate_time_.Add(board::MonotonicNs() - start_ns);
  const base::TimeNs result_ns = clock_.Now();
  const base::TimeNs last_packet_ns = std::max(left.stamp.last_packet_ns, right.stamp.last_packet_ns);
  trigger_to_result_.Add(result_ns - (left.stamp.mid_exposure_ns - exposure_ns_ / 2));
  packet_to_result_.Add(result_ns - last_packet_ns);
  counts_.pairs += 1;
  counts_.target_pairs += result_->fixes.targets.size();
  if (watch_ != nullptr) watch_->Add(result_->points);
  for (const georef::GeoFix& fix : result_->fixes.targets) {
    if (fix.state.points.status != stereo::FixStatus::kLost) counts_.located += 1;
  }
  Fill(to_publisher_.Draft(), last_packet_ns, result_ns);
  to_publisher_.Commit();  // what the publisher did not look at is not missed: it wants the newest
  if (!with_log) return;
  Fill(to_log_.Draft(), last_packet_ns, result_ns);
  if (to_log_.Commit() != nullptr) counts_.log_dropped += 1;
}

void PairLoop::Fill(FixRecord& record, base::TimeNs last_packet_ns, base::TimeNs result_ns) const {
  CopyFixes(result_->fixes, record.fixes);
  record.stamp = result_->points.stamp;
  record.last_packet_ns = last_packet_ns;
  record.result_ns = result_ns;
}

}  // namespace adit::app
