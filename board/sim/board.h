// The box "sim": any Linux PC, a laptop included. Its cameras are GigE Vision ones (real or simulated) or a
// recording, its field bus is SocketCAN or a log file. The one place that knows which driver serves which
// interface.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "drivers/linux/realtime.h"
#include "drivers/linux/signals.h"
#include "drivers/linux/system_clock.h"
#include "drivers/linux/wakeup.h"
#include "firmware/base/result.h"
#include "hal/camera.h"
#include "hal/datagram_port.h"
#include "hal/field_bus.h"
#include "hal/request_handler.h"

namespace adit::board {

using linux::MonotonicNs;
using linux::StopSignals;
using linux::SystemClock;
using linux::Wakeup;

/// One camera as the configuration asks for it.
struct CameraOrder {
  std::string driver;     ///< "aravis" or "recording"
  std::string device;     ///< address or id (aravis)
  std::string recording;  ///< folder (recording)
  base::Side side = base::Side::kLeft;
  int width_px = 0, height_px = 0;  ///< the rig's: a camera that delivers another size is refused
  int bits = 8;
  double rate_hz = 60, exposure_us = 1000, gain_db = 0;
  int packet_size = 9000;
  bool packet_socket = true;
  std::string trigger_source;
  bool ptp = true;
  int buffers = 16;
  int priority = 0;                             ///< of the driver's receiving thread, as for PrepareThread
  base::TimeNs replay_epoch_ns = base::kNever;  ///< when a recording begins again; the same for both sides
};

/// Makes the camera; Start opens it. `clock` outlives it.
std::unique_ptr<hal::Camera> MakeCamera(const CameraOrder& order, const hal::Clock& clock);

/// A field bus as the configuration asks for it.
struct FieldBusOrder {
  std::string driver;          ///< "socketcan" or "candump"
  std::string interface_name;  ///< "can0"
  std::string log;             ///< file (candump)
};

/// Opens the bus; declines with the interface or file. `clock` outlives it.
base::Result<std::unique_ptr<hal::FieldBus>> OpenFieldBus(const FieldBusOrder& order,
                                                          const hal::Clock& clock);

/// Opens the way to a receiver of datagrams; declines with address and port.
base::Result<std::unique_ptr<hal::DatagramPort>> OpenDatagrams(const std::string& address, int port);

/// Connections that a register server holds at once; one more is refused.
constexpr std::uint16_t kModbusClientsMax = 32;

/// A server that answers a PLC until it is destroyed.
class RegisterServer {
 public:
  virtual ~RegisterServer() = default;
  virtual std::uint32_t Clients() const = 0;
};

/// Serves Modbus TCP from a thread of its own; `handler` outlives the server. Declines with address and port.
base::Result<std::unique_ptr<RegisterServer>> ServeModbus(const std::string& address, int port,
                                                          hal::RequestHandler& handler);

/// Replaces a file as a whole; what reads it sees the old one or the new one. Not flushed: it may be lost
/// with the power. Declines with the file.
base::Result<void> ReplaceFile(const std::string& path, const std::string& bytes);

/// Names the calling thread and asks for its priority (0: none) and processor (-1: any). What was refused is
/// kept for RealtimeReport.
void PrepareThread(const std::string& name, int priority, int cpu);

/// Locks the program in memory; what was refused is kept for RealtimeReport.
void LockMemory();

/// One line: "" when everything that was asked was granted.
std::string RealtimeReport();

}  // namespace adit::board
