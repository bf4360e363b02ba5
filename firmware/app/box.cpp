#include "firmware/app/box.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/georef/absolute_orientation.h"
#include "firmware/identify/model.h"

#ifndef ADIT_VERSION
#error "the build defines ADIT_VERSION"
#endif

namespace adit::app {
namespace {

// A recording starts this much after the program, when all threads wait for it.
constexpr base::DurationNs kReplayDelayNs = base::kNsPerS;

board::CameraOrder OrderOf(const config::BoxConfig& config, base::Side side,
                           const optics::CameraModel& model) {
  const config::CamerasConfig& cameras = config.cameras;
  board::CameraOrder order;
  order.driver = cameras.driver;
  order.device = side == base::Side::kLeft ? cameras.left.device : cameras.right.device;
  order.recording = config.Resolve(cameras.recording);
  order.side = side;
  order.width_px = model.width_px;
  order.height_px = model.height_px;
  order.bits = static_cast<int>(cameras.bits);
  order.rate_hz = cameras.rate_hz;
  order.exposure_us = cameras.exposure_us;
  order.gain_db = cameras.gain_db;
  order.packet_size = static_cast<int>(cameras.packet_size);
  order.packet_socket = cameras.socket == "packet";
  order.trigger_source = cameras.trigger_source;
  order.ptp = cameras.ptp;
  order.buffers = static_cast<int>(cameras.buffers);
  order.priority = static_cast<int>(config.realtime.priority);
  return order;
}

/// Where the published targets and bodies stand among `names`.
base::Result<std::vector<std::size_t>> PublishedTargets(const config::BoxConfig& config,
                                                        const std::vector<std::string>& names) {
  std::vector<std::size_t> targets;
  for (const std::string& name : config.publish.targets) {
    const auto place = std::find(names.begin(), names.end(), name);
    if (place == names.end()) {
      return base::Error{base::ErrorCode::kOutOfRange, "publish.targets",
                         "'" + name + "' is the name of no model or body"};
    }
    targets.push_back(static_cast<std::size_t>(place - names.begin()));
  }
  if (targets.empty()) {
    for (std::size_t i = 0; i < names.size(); ++i) targets.push_back(i);
  }
  constexpr std::size_t kLastNode = 126;  // CiA 301 has nodes 1 to 127; each target takes two
  if (static_cast<std::size_t>(config.publish.can.node) + 2 * (targets.size() - 1) > kLastNode) {
    return base::Error{base::ErrorCode::kOutOfRange, "publish.can.node",
                       "leaves no room for " + std::to_string(targets.size()) + " targets below node 127"};
  }
  return targets;
}

/// The rig in the site grid, or none if the configuration names no file.
base::Result<georef::Georeference> LoadTie(const config::BoxConfig& config, const optics::Rig& rig) {
  if (config.georeference.empty()) return georef::Georeference();
  const auto orientation = georef::LoadOrientation(config.Resolve(config.georeference), rig.calibration_id);
  if (!orientation) return orientation.error();
  const std::vector<double>& origin_m = config.publish.site_origin_m;
  const Eigen::Vector3d& rig_s_m = orientation->T_s_b.translation_m;
  if (!publish::FitsTheWire(rig_s_m - Eigen::Vector3d(origin_m[0], origin_m[1], origin_m[2]))) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(0) << "is more than " << publish::kOffsetMaxM
         << " m from the rig, which stands at [" << rig_s_m.x() << ", " << rig_s_m.y() << ", " << rig_s_m.z()
         << "]: no position would fit the bus";
    return base::Error{base::ErrorCode::kOutOfRange, "publish.site_origin_m", text.str()};
  }
  return georef::Georeference(*orientation);
}

/// What a rig of unknown uncertainty may be off by: as much as the stereo stage forgives, 1 px and 0.5 %.
watch::MotionMatrix CoarseCovariance(const optics::Rig& rig) {
  const double angle_rad = stereo::LocatorOptions{}.epipolar_px / rig.right.fu_px;
  const double shift_m = stereo::LocatorOptions{}.scale * rig.BaselineM();
  watch::MotionMatrix covariance = watch::MotionMatrix::Zero();
  covariance.diagonal().head<3>().setConstant(angle_rad * angle_rad);
  covariance.diagonal().tail<3>().setConstant(shift_m * shift_m);
  return covariance;
}

/// The watch over the calibration, or null if it is switched off.
base::Result<std::unique_ptr<CalibrationWatch>> MakeWatch(const config::BoxConfig& config,
                                                          const optics::Rig& rig,
                                                          const std::vector<identify::Model>& models) {
  if (!config.watch.enabled) return std::unique_ptr<CalibrationWatch>();
  const auto covariance = optics::LoadRigCovariance(config.Resolve(config.rig));
  if (!covariance) return covariance.error();
  std::vector<base::Target> targets;
  for (const identify::Model& model : models) targets.push_back(model.target);
  watch::WatchOptions options;
  options.rate_hz = config.cameras.rate_hz;
  options.learn_s = static_cast<int>(config.watch.learn_s);
  options.shift_sigma_m = config.watch.shift_mm * 1e-3;
  const std::vector<double>& lights_m = config.watch.lights_m;
  for (std::size_t i = 0; i + 2 < lights_m.size(); i += 3)
    options.lights_b_m.emplace_back(lights_m[i], lights_m[i + 1], lights_m[i + 2]);
  const watch::MotionMatrix believed =
      *covariance ? watch::MotionMatrix((*covariance)->topLeftCorner<6, 6>()) : CoarseCovariance(rig);
  return std::make_unique<CalibrationWatch>(rig, targets, options, believed);
}

base::DurationNs Nanoseconds(double seconds) {
  return static_cast<base::DurationNs>(std::llround(seconds * static_cast<double>(base::kNsPerS)));
}

}  // namespace

base::Result<std::unique_ptr<Box>> Box::Make(const config::BoxConfig& config) {
  const auto rig = optics::LoadRig(config.Resolve(config.rig));
  if (!rig) return rig.error();
  std::vector<identify::Model> models;
  for (const std::string& file : config.models) {
    auto model = identify::LoadModel(config.Resolve(file));
    if (!model) return model.error();
    models.push_back(*model);
  }
  const auto georeference = LoadTie(config, *rig);
  if (!georeference) return georeference.error();
  pipeline::PipelineOptions options;
  options.tracker.filter = config.track.filter;
  std::vector<std::string> body_files;
  for (const std::string& file : config.bodies) body_files.push_back(config.Resolve(file));
  auto bodies =
      track::LoadBodies(body_files, pipeline::TargetsOf(models), identify::kMaxTargets - models.size());
  if (!bodies) return bodies.error();
  options.tracker.bodies = std::move(*bodies);
  options.georeference = *georeference;
  const config::DetectorConfig& d = config.detector;
  options.detector = {d.area_min_px, d.area_max_px, d.elongation_max, d.read_noise_dn, d.electrons_per_dn};
  auto pipeline = pipeline::Pipeline::Make(*rig, models, options);
  if (!pipeline) return pipeline.error();
  auto watch = MakeWatch(config, *rig, models);
  if (!watch) return watch.error();
  const auto targets = PublishedTargets(config, pipeline->Names());
  if (!targets) return targets.error();
  std::unique_ptr<Box> box(new Box(config, *rig, std::move(*pipeline)));
  if (*watch) box->pair_loop_->ShowTo(**watch);
  box->publisher_options_.watch = watch->get();
  box->watch_ = std::move(*watch);
  box->publisher_options_.targets = *targets;
  return box;
}

Box::Box(const config::BoxConfig& config, const optics::Rig& rig, pipeline::Pipeline pipeline)
    : config_(config), calibration_id_(rig.calibration_id), pipeline_(std::move(pipeline)) {
  board::CameraOrder left = OrderOf(config, base::Side::kLeft, rig.left);
  board::CameraOrder right = OrderOf(config, base::Side::kRight, rig.right);
  left.replay_epoch_ns = right.replay_epoch_ns = clock_.Now() + kReplayDelayNs;
  left_camera_ = board::MakeCamera(left, clock_);
  right_camera_ = board::MakeCamera(right, clock_);
  const base::DurationNs period_ns = Nanoseconds(1 / config.cameras.rate_hz);
  // The pairing thread waits on a wake-up of its own, so the lanes come after it.
  pair_loop_ = std::make_unique<PairLoop>(
      pipeline_, latency_, TriggerTimes{period_ns, Nanoseconds(config.cameras.exposure_us * 1e-6)});
  const auto lane = [this](base::Side side, hal::Camera& camera) {
    return std::make_unique<CameraLane>(side,
                                        LaneNeighbours{camera, pipeline_, pair_loop_->Wake(), latency_});
  };
  left_ = lane(base::Side::kLeft, *left_camera_);
  right_ = lane(base::Side::kRight, *right_camera_);

  PublisherOptions& p = publisher_options_;
  p.rules.sigma_limit_m = config.publish.sigma_limit_mm * 1e-3;
  p.rules.age_limit_ns = Nanoseconds(config.publish.age_limit_ms * 1e-3);
  for (std::size_t i = 0; i < 3; ++i)
    p.rules.origin_s_m[i] = static_cast<std::int32_t>(config.publish.site_origin_m[i]);
  p.cycle_ns = Nanoseconds(config.publish.can.cycle_ms * 1e-3);
  p.period_ns = period_ns;
  p.simulation = config.simulation;
  p.ptp_expected = config.cameras.ptp && config.cameras.driver == "aravis";
  p.node = static_cast<std::uint8_t>(config.publish.can.node);
  if (config.publish.modbus.enabled) p.modbus_clients_max = board::kModbusClientsMax;
  map_ = std::make_unique<publish::RegisterMap>(
      publish::MakeIdentity(config.serial, ADIT_VERSION, config.crc32), p.rules);
}

Box::~Box() { Stop(); }

base::Result<void> Box::OpenOutputs() {
  const config::CanConfig& can = config_.publish.can;
  if (can.driver != "none") {
    auto bus = board::OpenFieldBus({can.driver, can.interface_name, config_.Resolve(can.log)}, clock_);
    if (!bus) return bus.error();
    bus_ = std::move(*bus);
  }
  const config::DtrackConfig& dtrack = config_.publish.dtrack;
  if (!dtrack.address.empty()) {
    auto datagrams = board::OpenDatagrams(dtrack.address, static_cast<int>(dtrack.port));
    if (!datagrams) return datagrams.error();
    datagrams_ = std::move(*datagrams);
  }
  const config::ModbusConfig& modbus = config_.publish.modbus;
  if (modbus.enabled) {
    answers_ = std::make_unique<Answers>(*map_, static_cast<std::uint8_t>(modbus.unit));
    auto server = board::ServeModbus(modbus.bind, static_cast<int>(modbus.port), *answers_);
    if (!server) return server.error();
    modbus_ = std::move(*server);
  }
  if (!config_.track_log.empty()) {
    if (auto open = track_log_.Open(config_.Resolve(config_.track_log), pipeline_.Names()); !open)
      return open.error();
  }
  return {};
}

base::Result<void> Box::Start() {
  if (auto open = OpenOutputs(); !open) return open.error();
  // Against the way of the data, the cameras last: a frame that comes finds everyone awake, and no page of
  // memory or thread is still to be made while frames wait.
  if (config_.realtime.lock_memory) board::LockMemory();
  const PublisherSources sources{pair_loop_->ToPublisher(), *left_, *right_, latency_};
  publisher_ = std::make_unique<Publisher>(publisher_options_, sources, *map_,
                                           PublisherOutlets{bus_.get(), datagrams_.get()});
  const auto thread = [this](std::size_t place) {
    const auto& cpus = config_.realtime.cpus;
    return ThreadOptions{static_cast<int>(config_.realtime.priority),
                         cpus.empty() ? -1 : static_cast<int>(cpus[place % cpus.size()])};
  };
  publisher_->Start(thread(0));
  if (track_log_.IsOpen()) track_log_.Start(pair_loop_->ToLog());
  pair_loop_->Start(
      thread(0), {*left_, *right_, publisher_->Wake(), track_log_.IsOpen() ? &track_log_.Wake() : nullptr});
  if (auto start = left_camera_->Start(); !start) return start.error();
  left_->Start(thread(0));
  if (auto start = right_camera_->Start(); !start) return start.error();
  right_->Start(thread(1));
  start_monotonic_ns_ = status_monotonic_ns_ = board::MonotonicNs();
  running_ = true;
  return WriteHealth(TakeStatus());
}

void Box::Stop() {
  // The publisher first, so that machines hear nothing of cameras that fall silent because we stop; then with
  // the way of the data: every image that was taken goes through and is counted.
  if (publisher_) publisher_->Stop();
  if (left_) left_->Stop();
  if (left_camera_) left_camera_->Stop();  // before it runs out of buffers, which nobody gives back now
  if (right_) right_->Stop();
  if (right_camera_) right_camera_->Stop();
  if (pair_loop_) pair_loop_->Stop();
  track_log_.Stop();
  modbus_.reset();
  running_ = false;
}

Status Box::TakeStatus() {
  Status status;
  const std::int64_t now_ns = board::MonotonicNs();
  constexpr double kNsPerS = base::kNsPerS;
  status.uptime_s = static_cast<double>(now_ns - start_monotonic_ns_) / kNsPerS;
  status.left = left_->Health();
  status.right = right_->Health();
  status.pairs = pair_loop_->Health();
  const double since_s = static_cast<double>(now_ns - status_monotonic_ns_) / kNsPerS;
  status.rate_hz = since_s > 0 ? static_cast<double>(status.pairs.pairs - status_pairs_) / since_s : 0;
  status_monotonic_ns_ = now_ns;
  status_pairs_ = status.pairs.pairs;
  if (modbus_) {
    status.modbus_clients = modbus_->Clients();
    publisher_->SetModbusClients(status.modbus_clients);
  }
  status.publish = publisher_->Health();
  status.calibration_id = calibration_id_;
  if (watch_) status.finding = watch_->Latest();
  status.bus = publisher_->BusHealth();
  status.latency = &latency_;
  status.running = running_;
  return status;
}

base::Result<void> Box::WriteHealth(const Status& status) const {
  if (config_.health_report.empty()) return {};
  const publish::HealthReport report = ReportOf(status, clock_.Now(), board::RealtimeReport());
  return board::ReplaceFile(config_.Resolve(config_.health_report), publish::FormatHealthReport(report));
}

}  // namespace adit::app
