// The pairing thread: blob sets of both cameras -> pairs -> fixes for the publisher and the track log.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "board/sim/board.h"
#include "firmware/app/calibration_watch.h"
#include "firmware/app/camera_lane.h"
#include "firmware/app/fix_record.h"
#include "firmware/base/histogram.h"
#include "firmware/base/latest.h"
#include "firmware/capture/pairer.h"
#include "firmware/pipeline/pipeline.h"

namespace adit::app {

/// Counters of the pairing thread; monotonic.
struct PairHealth {
  std::uint64_t pairs = 0;         ///< pairs that went through the pipeline
  std::uint64_t unpaired = 0;      ///< images that found no partner, from the first pair on
  std::uint64_t target_pairs = 0;  ///< pairs times targets
  std::uint64_t located = 0;       ///< of these, with a position
  std::uint64_t log_dropped = 0;   ///< records the track log was too slow for
};

/// Whom the pairing thread takes from and wakes.
struct PairNeighbours {
  CameraLane& left;
  CameraLane& right;
  board::Wakeup& publisher;  ///< signalled after every record for it
  board::Wakeup* log;        ///< the same; null: no log
};

/// One thread. All that is given outlives it.
class PairLoop {
 public:
  PairLoop(pipeline::Pipeline& pipeline, base::DurationNs period_ns, base::DurationNs exposure_ns);
  ~PairLoop();

  /// Before Start: every pair is shown to `watch`, which outlives this.
  void ShowTo(CalibrationWatch& watch) { watch_ = &watch; }

  void Start(const ThreadOptions& options, const PairNeighbours& neighbours);
  void Stop();

  /// Signalled by the lanes after every blob set.
  board::Wakeup& Wake() { return wake_; }
  PublishConveyor& ToPublisher() { return to_publisher_; }
  LogConveyor& ToLog() { return to_log_; }
  /// Both lanes have ended and every pair is through.
  bool Ended() const { return ended_.load(std::memory_order_acquire); }
  PairHealth Health() const { return health_.Load(); }
  const base::DurationHistogram& TriggerToResult() const { return trigger_to_result_; }
  const base::DurationHistogram& PacketToResult() const { return packet_to_result_; }
  const base::DurationHistogram& LocateTime() const { return locate_time_; }

 private:
  using Event = capture::PairerEvent<detect::BlobSet*>;

  void Run(const PairNeighbours& neighbours);
  bool Take(CameraLane& lane);
  void Handle(const Event& event, const PairNeighbours& neighbours);
  void Locate(const detect::BlobSet& left, const detect::BlobSet& right, bool with_log);
  void Fill(FixRecord& record, base::TimeNs last_packet_ns, base::TimeNs result_ns) const;

  CalibrationWatch* watch_ = nullptr;
  pipeline::Pipeline& pipeline_;
  base::DurationNs exposure_ns_;
  capture::Pairer<detect::BlobSet*> pairer_;
  board::SystemClock clock_;
  board::Wakeup wake_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, ended_{false};

  std::unique_ptr<pipeline::PairResult> result_;
  PublishConveyor to_publisher_;
  LogConveyor to_log_;
  PairHealth counts_;
  base::Latest<PairHealth> health_;
  base::DurationHistogram trigger_to_result_, packet_to_result_, locate_time_;
};

}  // namespace adit::app
