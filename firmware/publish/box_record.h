// What else the box tells about itself: counters, and who it is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/publish/epoch.h"

namespace adit::publish {

struct CameraFigures {
  double rate_hz = 0;      ///< frames delivered a second
  std::uint32_t lost = 0;  ///< triggers without a usable frame since start
};

/// Counters since start; they wrap.
struct BoxHealth {
  std::uint32_t uptime_s = 0;
  std::uint32_t restarts = 0;
  std::optional<double> temperature_celsius;
  std::array<CameraFigures, 2> cameras{};  ///< A (left), B (right)
  std::optional<double> radio_loss;        ///< share of packets, 0 to 1
  std::optional<std::uint16_t> filter_position;
  std::uint32_t can_sent_frames = 0;
  std::uint32_t can_errors = 0;
  std::uint32_t can_bus_off = 0;
  std::uint32_t can_dropped_epochs = 0;
  std::uint16_t modbus_clients = 0;
  std::uint16_t modbus_clients_max = 0;
};

/// Up to 32 ASCII characters, zero padded; longer text is cut.
using Label = std::array<char, 32>;
Label MakeLabel(std::string_view text);
std::string_view TextOf(const Label& label);

/// Who the box is. Fixed from start to end.
struct BoxIdentity {
  Label vendor{};
  Label product{};
  Label serial{};
  Label version{};
  std::array<std::uint8_t, 3> version_numbers{};  ///< major, minor, patch
  std::uint32_t serial_number = 0;                ///< the serial if it is a number, else 0
  std::uint32_t config_crc32 = 0;
  std::uint32_t epsg = 0;            ///< of the site grid; 0 unknown
  std::uint32_t alignment_hash = 0;  ///< 0: none loaded
};

/// Fills in vendor and product; reads the numbers out of "1.2.3" and of a numeric serial.
BoxIdentity MakeIdentity(std::string_view serial, std::string_view version, std::uint32_t config_crc32);

/// All that CAN frames and box registers are made of.
struct BoxRecord {
  Epoch epoch;
  BoxHealth health;
  BoxIdentity identity;
  base::TimeNs now_ns = base::kNever;  ///< hand-over to the controller: ages are taken here
  bool publisher_alive = false;        ///< the publisher spoke within the last second
};

}  // namespace adit::publish
