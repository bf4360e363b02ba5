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

PairLoop::PairLoop(pipeline::Pipeline& pipeline, LatencyTable& latency, const TriggerTimes& times)
    : pipeline_(pipeline),
      latency_(latency),
      exposure_ns_(times.exposure_ns),
      pairer_(PairerOptionsOf(times.period_ns)),
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
  for (;;) {
    // Read before the last look into the lanes, or an end could overtake a blob set.
    const bool left_ended = neighbours.left.Ended(), right_ended = neighbours.right.Ended();
    const bool last_look = (left_ended && right_ended) || stop_.load(std::memory_order_relaxed);
    // Once a camera has ended, the other's images wait for the end: nothing was lost between the two.
    const base::TimeNs now_ns = left_ended || right_ended ? base::kNever : clock_.Now();
    bool took = false;
    for (CameraLane* const lane : {&neighbours.left, &neighbours.right}) {
      took = Take(*lane) || took;
      while (const auto event = pairer_.Next(now_ns)) Handle(*event, neighbours, false);
    }
    if (took) continue;
    if (last_look) break;
    wake_.WaitFor(kTickNs);
  }
  while (const auto event = pairer_.Flush()) Handle(*event, neighbours, true);
  // release: whoever sees the end also sees the last record.
  ended_.store(true, std::memory_order_release);
}

bool PairLoop::Take(CameraLane& lane) {
  Detection* const detection = lane.Pop();
  if (detection == nullptr) return false;
  pairer_.Add(detection->blobs.stamp, detection);
  return true;
}

void PairLoop::Handle(const Event& event, const PairNeighbours& neighbours, bool at_end) {
  if (event.Paired()) {
    Locate(**event.left, **event.right, neighbours.log != nullptr);
    neighbours.publisher.Signal();
    if (neighbours.log != nullptr) neighbours.log->Signal();
  } else {
    LoneImages& images = counts_.lone[event.left ? 0 : 1];
    // Before the first pair, one camera waits for the other to start.
    (at_end || counts_.pairs == 0 ? images.at_ends : images.unpaired) += 1;
  }
  if (event.left) neighbours.left.GiveBack(*event.left);
  if (event.right) neighbours.right.GiveBack(*event.right);
  health_.Store(counts_);
}

void PairLoop::Locate(const Detection& left, const Detection& right, bool with_log) {
  const std::int64_t start_ns = board::MonotonicNs();
  pipeline_.Locate(left.blobs, right.blobs, *result_);
  Measure(left, right, start_ns);
  counts_.pairs += 1;
  counts_.target_pairs += result_->fixes.targets.size();
  if (watch_ != nullptr) watch_->Add(result_->points);
  for (const georef::GeoFix& fix : result_->fixes.targets) {
    if (fix.state.points.status != stereo::FixStatus::kLost) counts_.located += 1;
  }
  Fill(to_publisher_.Draft());
  to_publisher_.Commit();  // what the publisher did not look at is not missed: it wants the newest
  if (!with_log) return;
  Fill(to_log_.Draft());
  if (to_log_.Commit() != nullptr) counts_.log_dropped += 1;
}

/// The result of this pair is ready now.
void PairLoop::Measure(const Detection& left, const Detection& right, std::int64_t start_monotonic_ns) {
  const auto [first_ns, complete_ns] = std::minmax(left.ready_monotonic_ns, right.ready_monotonic_ns);
  const std::int64_t now_monotonic_ns = board::MonotonicNs();
  result_ns_ = clock_.Now();
  last_packet_ns_ = std::max(left.blobs.stamp.last_packet_ns, right.blobs.stamp.last_packet_ns);
  const base::TimeNs mid_exposure_ns = left.blobs.stamp.mid_exposure_ns;
  latency_[Span::kPairWait].Add(complete_ns - first_ns);
  latency_[Span::kLocate].Add(now_monotonic_ns - start_monotonic_ns);
  latency_[Span::kPairToResult].Add(now_monotonic_ns - complete_ns);
  latency_[Span::kPacketToResult].Add(result_ns_ - last_packet_ns_);
  latency_[Span::kExposureToResult].Add(result_ns_ - mid_exposure_ns);
  latency_[Span::kTriggerToResult].Add(result_ns_ - (mid_exposure_ns - exposure_ns_ / 2));
}

void PairLoop::Fill(FixRecord& record) const {
  CopyFixes(result_->fixes, record.fixes);
  record.stamp = result_->points.stamp;
  record.last_packet_ns = last_packet_ns_;
  record.result_ns = result_ns_;
}

}  // namespace adit::app
