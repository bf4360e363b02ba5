// The pairing thread: blob sets of both cameras -> pairs -> fixes for the publisher and the track log.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <thread>

#include "board/sim/board.h"
#include "firmware/app/calibration_watch.h"
#include "firmware/app/camera_lane.h"
#include "firmware/app/fix_record.h"
#include "firmware/base/latest.h"
#include "firmware/capture/pairer.h"
#include "firmware/pipeline/pipeline.h"

namespace adit::app {

/// What became of one camera's images beside those in pairs; monotonic.
struct LoneImages {
  std::uint64_t unpaired = 0;  ///< found no partner between the first pair and the last
  std::uint64_t at_ends = 0;   ///< one camera started or stopped before the other
};

/// Counters of the pairing thread; monotonic.
struct PairHealth {
  std::uint64_t pairs = 0;         ///< pairs that went through the pipeline
  std::array<LoneImages, 2> lone;  ///< left, right
  std::uint64_t target_pairs = 0;  ///< pairs times targets
  std::uint64_t located = 0;       ///< of these, with a position
  std::uint64_t log_dropped = 0;   ///< records the track log was too slow for

  std::uint64_t Unpaired() const { return lone[0].unpaired + lone[1].unpaired; }
};

/// Whom the pairing thread takes from and wakes.
struct PairNeighbours {
  CameraLane& left;
  CameraLane& right;
  board::Wakeup& publisher;  ///< signalled after every record for it
  board::Wakeup* log;        ///< the same; null: no log
};

/// Times of the common trigger.
struct TriggerTimes {
  base::DurationNs period_ns = base::kNsPerS / 60;
  base::DurationNs exposure_ns = base::kNsPerMs;
};

/// One thread. All that is given outlives it.
class PairLoop {
 public:
  PairLoop(pipeline::Pipeline& pipeline, LatencyTable& latency, const TriggerTimes& times);
  ~PairLoop();

  /// Before Start: every pair is shown to `watch`, which outlives this.
  void ShowTo(CalibrationWatch& watch) { watch_ = &watch; }

  void Start(const ThreadOptions& options, const PairNeighbours& neighbours);
  /// After the lanes: what they have left goes through first, so that every image is accounted for.
  void Stop();

  /// Signalled by the lanes after every blob set.
  board::Wakeup& Wake() { return wake_; }
  PublishConveyor& ToPublisher() { return to_publisher_; }
  LogConveyor& ToLog() { return to_log_; }
  /// Both lanes have ended and every pair is through.
  bool Ended() const { return ended_.load(std::memory_order_acquire); }
  PairHealth Health() const { return health_.Load(); }

 private:
  using Event = capture::PairerEvent<Detection*>;

  void Run(const PairNeighbours& neighbours);
  bool Take(CameraLane& lane);
  void Handle(const Event& event, const PairNeighbours& neighbours, bool at_end);
  void Locate(const Detection& left, const Detection& right, bool with_log);
  void Measure(const Detection& left, const Detection& right, std::int64_t start_monotonic_ns);
  void Fill(FixRecord& record) const;

  CalibrationWatch* watch_ = nullptr;
  pipeline::Pipeline& pipeline_;
  LatencyTable& latency_;
  base::DurationNs exposure_ns_;
  capture::Pairer<Detection*> pairer_;
  board::SystemClock clock_;
  board::Wakeup wake_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, ended_{false};

  std::unique_ptr<pipeline::PairResult> result_;
  base::TimeNs last_packet_ns_ = base::kNever, result_ns_ = base::kNever;  ///< of the present pair
  PublishConveyor to_publisher_;
  LogConveyor to_log_;
  PairHealth counts_;
  base::Latest<PairHealth> health_;
};

}  // namespace adit::app
