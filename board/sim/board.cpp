#include "board/sim/board.h"

#include <mutex>
#include <vector>

#include "drivers/aravis/aravis_camera.h"
#include "drivers/linux/atomic_file.h"
#include "drivers/linux/udp_port.h"
#include "drivers/modbus/modbus_server.h"
#include "drivers/recording/recording_camera.h"
#include "drivers/socketcan/candump_bus.h"
#include "drivers/socketcan/socketcan_bus.h"

namespace adit::board {
namespace {

/// What the system refused, collected while the threads start.
struct Refusals {
  std::mutex mutex;
  std::vector<std::string> texts;
};

Refusals& RefusalsOfThisProcess() {
  static Refusals refusals;
  return refusals;
}

void Keep(const linux::Grant& grant) {
  if (grant.granted) return;
  Refusals& refusals = RefusalsOfThisProcess();
  const std::lock_guard lock(refusals.mutex);
  for (const std::string& text : refusals.texts) {
    if (text == grant.text) return;
  }
  refusals.texts.push_back(grant.text);
}

class TcpRegisterServer final : public RegisterServer {
 public:
  explicit TcpRegisterServer(std::unique_ptr<modbus::ModbusServer> server) : server_(std::move(server)) {}
  std::uint32_t Clients() const override { return server_->Health().clients; }

 private:
  std::unique_ptr<modbus::ModbusServer> server_;
};

}  // namespace

base::Result<std::unique_ptr<hal::FieldBus>> OpenFieldBus(const FieldBusOrder& order,
                                                          const hal::Clock& clock) {
  if (order.driver == "candump") {
    auto bus = socketcan::CandumpBus::Open(order.log, order.interface_name, clock);
    if (!bus) return bus.error();
    return std::unique_ptr<hal::FieldBus>(std::move(*bus));
  }
  auto bus = socketcan::SocketCanBus::Open(order.interface_name);
  if (!bus) return bus.error();
  return std::unique_ptr<hal::FieldBus>(std::move(*bus));
}

base::Result<std::unique_ptr<hal::DatagramPort>> OpenDatagrams(const std::string& address, int port) {
  auto datagrams = linux::UdpPort::Open(address, port);
  if (!datagrams) return datagrams.error();
  return std::unique_ptr<hal::DatagramPort>(std::move(*datagrams));
}

base::Result<std::unique_ptr<RegisterServer>> ServeModbus(const std::string& address, int port,
                                                          hal::RequestHandler& handler) {
  modbus::ServerOptions options;
  options.bind = address;
  options.port = static_cast<std::uint16_t>(port);
  options.connections_max = kModbusClientsMax;
  auto server = modbus::ModbusServer::Open(options, handler);
  if (!server) return server.error();
  return std::unique_ptr<RegisterServer>(std::make_unique<TcpRegisterServer>(std::move(*server)));
}

std::unique_ptr<hal::Camera> MakeCamera(const CameraOrder& order, const hal::Clock& clock) {
  if (order.driver == "recording") {
    recording::ReplayOptions options;
    options.folder = order.recording;
    options.side = order.side;
    options.width_px = order.width_px;
    options.height_px = order.height_px;
    options.buffers = order.buffers;
    options.epoch_ns = order.replay_epoch_ns;
    return std::make_unique<recording::RecordingCamera>(options, clock);
  }
  aravis::AravisSettings settings;
  settings.device = order.device;
  settings.side = order.side;
  settings.width_px = order.width_px;
  settings.height_px = order.height_px;
  settings.bits = order.bits;
  settings.exposure_us = order.exposure_us;
  settings.gain_db = order.gain_db;
  settings.packet_size = order.packet_size;
  settings.packet_socket = order.packet_socket;
  settings.trigger_source = order.trigger_source;
  settings.ptp = order.ptp;
  settings.buffers = order.buffers;
  const std::string name = order.side == base::Side::kLeft ? "receive-left" : "receive-right";
  settings.prepare_receiving = [name, priority = order.priority] { PrepareThread(name, priority, -1); };
  return std::make_unique<aravis::AravisCamera>(settings, clock);
}

base::Result<void> ReplaceFile(const std::string& path, const std::string& bytes) {
  return linux::WriteFileAtomically(path, bytes, linux::Flush::kNo);
}

void PrepareThread(const std::string& name, int priority, int cpu) {
  Keep(linux::NameThread(name));
  if (priority > 0) Keep(linux::SetRealtimePriority(priority));
  if (cpu >= 0) Keep(linux::PinToCpu(cpu));
}

void LockMemory() { Keep(linux::LockMemory()); }

std::string RealtimeReport() {
  Refusals& refusals = RefusalsOfThisProcess();
  const std::lock_guard lock(refusals.mutex);
  std::string report;
  for (const std::string& text : refusals.texts) report += (report.empty() ? "" : "; ") + text;
  return report;
}

}  // namespace adit::board
