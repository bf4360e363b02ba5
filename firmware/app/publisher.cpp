#include "firmware/app/publisher.h"

#include <algorithm>

namespace adit::app {
namespace {

// Between two looks at the cameras: well below what INVALID may take (100 ms).
constexpr base::DurationNs kWakeTickNs = 10 * base::kNsPerMs;
// A camera is silent after 3.5 periods: three triggers without a frame, and half a period for the transfer.
// At 60 Hz that is 58 ms, which with a tick leaves 30 ms to the 100 ms within which machines must know.
constexpr double kSilentPeriods = 3.5;
// Both cameras deliver and yet nothing pairs for this long: they are not triggered together.
constexpr base::DurationNs kUnpairedNs = base::kNsPerS;
// An epoch out of turn (a fault came or went) keeps this distance from the last one, for the bus' sake: the
// smallest cycle.
constexpr base::DurationNs kShortestCycleNs = 20 * base::kNsPerMs;

}  // namespace

Publisher::Publisher(const PublisherOptions& options, const PublisherSources& sources,
                     publish::RegisterMap& map, const PublisherOutlets& outlets)
    : options_(options),
      fixes_(sources.fixes),
      left_(sources.left),
      right_(sources.right),
      latency_(sources.latency),
      map_(map),
      bus_(outlets.bus),
      datagrams_(outlets.datagrams) {
  for (std::size_t i = 0; i < options_.targets.size(); ++i) {
    encoders_.emplace_back(static_cast<std::uint8_t>(options_.node + 2 * i), map.Identity());
  }
  epochs_.resize(options_.targets.size());
}

Publisher::~Publisher() { Stop(); }

void Publisher::Start(const ThreadOptions& options) {
  start_monotonic_ns_ = board::MonotonicNs();
  thread_ = std::thread([this, options] {
    board::PrepareThread("publish", options.priority, options.cpu);
    Run();
  });
}

void Publisher::Stop() {
  // relaxed: looked at every tick; nothing is published through it.
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
  if (thread_.joinable()) thread_.join();
}

void Publisher::Run() {
  while (!stop_.load(std::memory_order_relaxed)) {
    wake_.WaitFor(kWakeTickNs);
    const bool took = TakeNewest();
    const std::int64_t now_ns = board::MonotonicNs();
    if (bus_ != nullptr) {
      bus_->Poll(now_ns);
      bus_health_.Store(bus_->Health());
    }
    if (IsDue(now_ns, took, Faults(now_ns) != told_faults_)) Tell(now_ns);
  }
}

bool Publisher::TakeNewest() {
  bool took = false;
  while (FixRecord* const record = fixes_.Pop()) {
    if (newest_ != nullptr) fixes_.GiveBack(newest_);
    newest_ = record;
    if (datagrams_ != nullptr) SendDatagram(*record);
    newest_is_fresh_ = took = true;
    last_fix_monotonic_ns_ = board::MonotonicNs();
  }
  return took;
}

void Publisher::SendDatagram(const FixRecord& record) {
  datagrams_->Send(datagram_.Encode(record.fixes, {++datagram_number_, record.stamp.mid_exposure_ns,
                                                   clock_.Now(), options_.rules.origin_s_m}));
}

bool Publisher::IsDue(std::int64_t monotonic_ns, bool took, bool faults_changed) const {
  const base::DurationNs since_ns = monotonic_ns - last_told_monotonic_ns_;
  if (faults_changed && since_ns >= kShortestCycleNs) return true;
  // A cycle ends with the pair nearest to its end, told the moment it comes, and waits for none that does
  // not.
  if (took) return since_ns >= options_.cycle_ns - options_.period_ns / 2;
  const bool pairs_flow = monotonic_ns - last_fix_monotonic_ns_ < 2 * options_.period_ns;
  return since_ns >= options_.cycle_ns + (pairs_flow ? options_.period_ns : 0);
}

std::uint16_t Publisher::Faults(std::int64_t monotonic_ns) const {
  const auto silent_ns =
      static_cast<base::DurationNs>(kSilentPeriods * static_cast<double>(options_.period_ns));
  std::uint16_t faults = 0;
  const bool a_silent =
      monotonic_ns - std::max(left_.LastFrameMonotonicNs(), start_monotonic_ns_) > silent_ns;
  const bool b_silent =
      monotonic_ns - std::max(right_.LastFrameMonotonicNs(), start_monotonic_ns_) > silent_ns;
  if (a_silent) faults |= publish::kFaultCameraA;
  if (b_silent) faults |= publish::kFaultCameraB;
  const std::int64_t last_fix_ns = std::max(last_fix_monotonic_ns_, start_monotonic_ns_);
  if (!a_silent && !b_silent && monotonic_ns - last_fix_ns > kUnpairedNs) faults |= publish::kFaultCameraSync;
  if (bus_ != nullptr) {
    const hal::FieldBusHealth bus = bus_->Health();
    if (bus.stalled) faults |= publish::kFaultCanStalled;
    if (bus.bus_off > 0) faults |= publish::kFaultBusOff;
  }
  if (options_.ptp_expected && (!left_.ClockLocked() || !right_.ClockLocked()))
    faults |= publish::kFaultTimeSync;
  if (options_.watch != nullptr && options_.watch->Latest().verdict == watch::Verdict::kChanged)
    faults |= publish::kFaultResidual;
  return faults;
}

const georef::GeoFix* Publisher::FixOf(std::size_t target) const {
  if (newest_ == nullptr || target >= newest_->fixes.targets.size()) return nullptr;
  return &newest_->fixes.targets[target];
}

publish::BoxCondition Publisher::Condition(std::int64_t monotonic_ns) const {
  publish::BoxCondition box;
  box.epoch = epoch_number_;
  box.alive = alive_;
  box.heartbeat = static_cast<std::uint16_t>((monotonic_ns - start_monotonic_ns_) / (100 * base::kNsPerMs));
  box.initialised = newest_ != nullptr;
  box.simulation = options_.simulation;
  box.georeferenced = newest_ != nullptr && newest_->fixes.georeferenced;
  box.faults = told_faults_;
  for (const std::size_t target : options_.targets) {
    const georef::GeoFix* const fix = FixOf(target);
    if (fix != nullptr && fix->state.points.status != stereo::FixStatus::kLost) box.targets_seen += 1;
  }
  const georef::GeoFix* const leading = FixOf(options_.targets.front());
  box.targets_used = leading != nullptr && leading->state.points.status != stereo::FixStatus::kLost ? 1 : 0;
  const bool locked = left_.ClockLocked() && right_.ClockLocked();
  box.clock = locked && options_.ptp_expected ? publish::ClockSource::kPtp : publish::ClockSource::kNone;
  return box;
}

publish::BoxHealth Publisher::CountForMachines(std::int64_t monotonic_ns) const {
  publish::BoxHealth health;
  const double uptime_s =
      static_cast<double>(monotonic_ns - start_monotonic_ns_) / static_cast<double>(base::kNsPerS);
  health.uptime_s = static_cast<std::uint32_t>(uptime_s);
  const std::array<const CameraLane*, 2> lanes{&left_, &right_};
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const LaneHealth lane = lanes[i]->Health();
    health.cameras[i].rate_hz = uptime_s > 0 ? static_cast<double>(lane.frames) / uptime_s : 0;
    health.cameras[i].lost =
        static_cast<std::uint32_t>(lane.camera.missed + lane.camera.incomplete + lane.Shed());
  }
  if (bus_ != nullptr) {
    const hal::FieldBusHealth bus = bus_->Health();
    health.can_sent_frames = static_cast<std::uint32_t>(bus.sent_frames);
    health.can_errors = static_cast<std::uint32_t>(bus.errors);
    health.can_bus_off = static_cast<std::uint32_t>(bus.bus_off);
    health.can_dropped_epochs = static_cast<std::uint32_t>(bus.dropped_epochs);
  }
  health.modbus_clients_max = options_.modbus_clients_max;
  // relaxed: a lone figure.
  health.modbus_clients = static_cast<std::uint16_t>(modbus_clients_.load(std::memory_order_relaxed));
  return health;
}

void Publisher::Tell(std::int64_t monotonic_ns) {
  epoch_number_ += 1;
  alive_ += 1;
  told_faults_ = Faults(monotonic_ns);
  last_told_monotonic_ns_ = monotonic_ns;
  const publish::BoxCondition box = Condition(monotonic_ns);
  const base::TimeNs now_ns = clock_.Now();
  for (std::size_t i = 0; i < epochs_.size(); ++i) {
    epochs_[i] = publish::MakeEpoch(FixOf(options_.targets[i]), box, options_.rules, now_ns);
  }
  const publish::BoxHealth counts = CountForMachines(monotonic_ns);
  if (bus_ != nullptr) Send(counts);
  map_.Update(epochs_.front(), box, counts, newest_ != nullptr ? newest_->fixes : no_fixes_, now_ns);
  newest_is_fresh_ = false;

  PublishHealth health = health_.Load();
  health.epochs += 1;
  const publish::Validity validity = epochs_.front().validity;
  if (validity == publish::Validity::kValid || validity == publish::Validity::kSimulated) health.valid += 1;
  health.faults = epochs_.front().faults;
  health.state = epochs_.front().state;
  health_.Store(health);
}

void Publisher::Send(const publish::BoxHealth& health) {
  frames_.clear();
  const base::TimeNs hand_over_ns = clock_.Now();
  for (std::size_t i = 0; i < encoders_.size(); ++i) {
    encoders_[i].Encode(epochs_[i], health, hand_over_ns, encoded_);
    for (const base::CanFrame& frame : encoded_) frames_.push_back(frame);
  }
  const hal::SendOutcome outcome = bus_->SendEpoch({frames_.data(), frames_.size()});
  if (outcome != hal::SendOutcome::kSent || !newest_is_fresh_) return;
  const base::TimeNs sent_ns = clock_.Now();
  latency_[Span::kResultToBus].Add(sent_ns - newest_->result_ns);
  latency_[Span::kPacketToBus].Add(sent_ns - newest_->last_packet_ns);
  latency_[Span::kExposureToBus].Add(sent_ns - newest_->stamp.mid_exposure_ns);
}

PublishHealth Publisher::Health() const { return health_.Load(); }

}  // namespace adit::app
