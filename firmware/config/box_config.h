// The box's one configuration file. One description of its keys makes the parser, the schema and the listing,
// so that they cannot disagree.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/base/result.h"

namespace adit::config {

struct CameraConfig {
  std::string device;  ///< IPv4 address or GigE Vision device id
};

struct CamerasConfig {
  std::string driver = "aravis";
  CameraConfig left, right;
  std::string recording;  ///< folder, for the driver "recording"
  double rate_hz = 60;
  double exposure_us = 1000;
  double gain_db = 0;
  long bits = 8;
  long packet_size = 9000;
  std::string socket = "packet";
  std::string trigger_source = "Line0";
  bool ptp = true;
  long buffers = 16;
};

struct DetectorConfig {
  double area_min_px = 4;
  double area_max_px = 1200;
  double elongation_max = 2.2;
  double read_noise_dn = 1.5;
  double electrons_per_dn = 40;
};

struct TrackConfig {
  bool filter = false;
};

struct CanConfig {
  std::string driver = "none";
  std::string interface_name = "can0";
  std::string log;  ///< file, for the driver "candump"
  long node = 0x20;
  double cycle_ms = 50;
};

struct ModbusConfig {
  bool enabled = false;
  std::string bind = "0.0.0.0";
  long port = 502;
  long unit = 1;
};

struct DtrackConfig {
  std::string address;  ///< empty: no datagrams
  long port = 5000;
};

struct PublishConfig {
  std::vector<std::string> targets;  ///< in the order of nodes; empty: all models and bodies
  std::vector<double> site_origin_m{0, 0, 0};
  double sigma_limit_mm = 20;
  double age_limit_ms = 100;
  CanConfig can;
  ModbusConfig modbus;
  DtrackConfig dtrack;
};

struct RealtimeConfig {
  long priority = 0;
  bool lock_memory = true;
  std::vector<double> cpus;
};

struct WatchConfig {
  bool enabled = true;
  long learn_s = 300;
  double shift_mm = 0.03;
  std::vector<double> lights_m;  ///< x, y, z in the rig frame, light after light
};

/// Everything a box needs to know. Paths are as written, relative to the configuration's folder; Resolve
/// makes them usable.
struct BoxConfig {
  std::string serial = "0";
  bool simulation = false;
  std::string rig;
  std::vector<std::string> models;
  std::vector<std::string> bodies;
  std::string georeference;  ///< file; empty: positions go out in the rig frame, with the fault bit
  CamerasConfig cameras;
  DetectorConfig detector;
  TrackConfig track;
  PublishConfig publish;
  WatchConfig watch;
  RealtimeConfig realtime;
  std::string track_log;
  std::string health_report;  ///< file; empty: none

  std::string folder;       ///< of the file it was read from
  std::uint32_t crc32 = 0;  ///< of the file's bytes: a changed configuration shows on the bus

  /// `path` as seen from the configuration's folder.
  std::string Resolve(const std::string& path) const;
};

/// Reads and checks a box file: unknown keys, wrong types, values out of range and missing files' keys are
/// refused with file, key, value and what is allowed.
base::Result<BoxConfig> LoadBoxConfig(const std::string& path);

/// Every key with type, unit, default, permitted values and meaning, as YAML with comments.
std::string FormatBoxSchema();

/// The configuration in effect, defaults included, as YAML that LoadBoxConfig reads.
std::string FormatBoxConfig(const BoxConfig& config);

}  // namespace adit::config
