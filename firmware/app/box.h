// The box: everything that runs, wired once.
#pragma once

#include <memory>
#include <vector>

#include "board/sim/board.h"
#include "firmware/app/camera_lane.h"
#include "firmware/app/pair_loop.h"
#include "firmware/app/publisher.h"
#include "firmware/app/status.h"
#include "firmware/app/track_log.h"
#include "firmware/base/result.h"
#include "firmware/config/box_config.h"
#include "firmware/optics/rig.h"
#include "firmware/publish/modbus_reply.h"
#include "firmware/publish/register_map.h"

namespace adit::app {

/// Reads all files, opens all devices, owns all threads. Belongs to the main thread.
class Box {
 public:
  /// Reads the rig and the models and checks them against the configuration. Opens nothing yet.
  static base::Result<std::unique_ptr<Box>> Make(const config::BoxConfig& config);
  ~Box();

  /// Opens the outputs, then the cameras, then starts the threads. Declines with the first that fails;
  /// nothing runs then.
  base::Result<void> Start();
  /// After it the counters account for every image.
  void Stop();

  /// A recording is over.
  bool Ended() const { return pair_loop_->Ended(); }
  /// Rates are since the last call.
  Status TakeStatus();
  /// Replaces the health report; nothing if the configuration names none. Declines with the file.
  base::Result<void> WriteHealth(const Status& status) const;

 private:
  Box(const config::BoxConfig& config, const optics::Rig& rig, pipeline::Pipeline pipeline);
  base::Result<void> OpenOutputs();

  /// Modbus requests are answered from the register map.
  class Answers final : public hal::RequestHandler {
   public:
    Answers(const publish::RegisterMap& map, std::uint8_t unit) : responder_(map, unit) {}
    std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply) override {
      return responder_.Answer(request, reply, clock_.Now());
    }

   private:
    publish::ModbusResponder responder_;
    board::SystemClock clock_;
  };

  config::BoxConfig config_;
  std::string calibration_id_;
  board::SystemClock clock_;
  PublisherOptions publisher_options_;
  LatencyTable latency_;
  pipeline::Pipeline pipeline_;
  std::unique_ptr<CalibrationWatch> watch_;  ///< null: switched off
  std::unique_ptr<hal::Camera> left_camera_, right_camera_;
  std::unique_ptr<PairLoop> pair_loop_;
  std::unique_ptr<CameraLane> left_, right_;
  std::unique_ptr<publish::RegisterMap> map_;
  std::unique_ptr<hal::FieldBus> bus_;
  std::unique_ptr<hal::DatagramPort> datagrams_;
  std::unique_ptr<Answers> answers_;
  std::unique_ptr<board::RegisterServer> modbus_;
  std::unique_ptr<Publisher> publisher_;
  TrackLog track_log_;
  bool running_ = false;
  std::int64_t start_monotonic_ns_ = 0;
  std::int64_t status_monotonic_ns_ = 0;
  std::uint64_t status_pairs_ = 0;
};

}  // namespace adit::app
