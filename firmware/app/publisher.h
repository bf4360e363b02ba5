// The publisher: a thread that tells the machines, every cycle and in every state, over CAN and Modbus.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "board/sim/board.h"
#include "firmware/app/calibration_watch.h"
#include "firmware/app/camera_lane.h"
#include "firmware/app/fix_record.h"
#include "firmware/base/latest.h"
#include "firmware/publish/can_encoder.h"
#include "firmware/publish/dtrack.h"
#include "firmware/publish/epoch.h"
#include "firmware/publish/register_map.h"
#include "hal/datagram_port.h"
#include "hal/field_bus.h"

namespace adit::app {

struct PublisherOptions {
  std::vector<std::size_t> targets;  ///< indices into the model list, in the order of their nodes
  publish::EpochRules rules;
  base::DurationNs cycle_ns = 50 * base::kNsPerMs;
  base::DurationNs period_ns = base::kNsPerS / 60;  ///< of the trigger
  bool simulation = false;
  bool ptp_expected = false;
  std::uint8_t node = 0x20;
  std::uint16_t modbus_clients_max = 0;     ///< for the diagnostics registers
  const CalibrationWatch* watch = nullptr;  ///< outlives the publisher; null: nobody watches
};

/// Counters of the publisher; monotonic but for the last line.
struct PublishHealth {
  std::uint64_t epochs = 0;  ///< cycles told
  std::uint64_t valid = 0;   ///< of these, leading target VALID or SIMULATED
  std::uint16_t faults = 0;  ///< of the last cycle
  publish::BoxState state = publish::BoxState::kInit;
};

/// What the publisher reads. All of it outlives the publisher.
struct PublisherSources {
  PublishConveyor& fixes;
  const CameraLane& left;
  const CameraLane& right;
  LatencyTable& latency;  ///< gets the way to the bus, of epochs that told a new pair
};

/// Whom the publisher tells, beside the register map; null: nobody. All of it outlives the publisher.
struct PublisherOutlets {
  hal::FieldBus* bus = nullptr;
  hal::DatagramPort* datagrams = nullptr;  ///< gets every pair
};

/// One thread. All that is given outlives it.
class Publisher {
 public:
  Publisher(const PublisherOptions& options, const PublisherSources& sources, publish::RegisterMap& map,
            const PublisherOutlets& outlets);
  ~Publisher();

  void Start(const ThreadOptions& options);
  void Stop();
  /// Signalled by the pairing thread after every record.
  board::Wakeup& Wake() { return wake_; }

  /// Modbus clients connected, for the diagnostics registers.
  void SetModbusClients(std::uint32_t clients) { modbus_clients_.store(clients, std::memory_order_relaxed); }

  PublishHealth Health() const;
  hal::FieldBusHealth BusHealth() const { return bus_health_.Load(); }

 private:
  void Run();
  bool TakeNewest();
  void SendDatagram(const FixRecord& record);
  bool IsDue(std::int64_t monotonic_ns, bool took, bool faults_changed) const;
  void Tell(std::int64_t monotonic_ns);
  void Send(const publish::BoxHealth& health);
  std::uint16_t Faults(std::int64_t monotonic_ns) const;
  publish::BoxCondition Condition(std::int64_t monotonic_ns) const;
  publish::BoxHealth CountForMachines(std::int64_t monotonic_ns) const;
  const georef::GeoFix* FixOf(std::size_t target) const;

  PublisherOptions options_;
  PublishConveyor& fixes_;
  const CameraLane& left_;
  const CameraLane& right_;
  LatencyTable& latency_;
  publish::RegisterMap& map_;
  hal::FieldBus* bus_;
  hal::DatagramPort* datagrams_;
  publish::DtrackEncoder datagram_;
  std::uint32_t datagram_number_ = 0;
  board::SystemClock clock_;
  board::Wakeup wake_;
  std::thread thread_;
  std::atomic<bool> stop_{false};

  std::vector<publish::CanEncoder> encoders_;
  std::vector<publish::Epoch> epochs_;  ///< of the present cycle, one a target
  publish::CanEncoder::Frames encoded_;
  base::FixedVector<base::CanFrame, publish::CanEncoder::kMaxFrames * identify::kMaxTargets> frames_;
  const georef::GeoFixSet no_fixes_;  ///< told until the first pair
  FixRecord* newest_ = nullptr;
  bool newest_is_fresh_ = false;
  std::int64_t start_monotonic_ns_ = 0;
  std::int64_t last_told_monotonic_ns_ = 0;
  std::int64_t last_fix_monotonic_ns_ = 0;
  std::uint16_t epoch_number_ = 0;
  std::uint16_t told_faults_ = 0;
  std::uint8_t alive_ = 0;

  std::atomic<std::uint32_t> modbus_clients_{0};
  base::Latest<PublishHealth> health_;
  base::Latest<hal::FieldBusHealth> bus_health_;
};

}  // namespace adit::app
