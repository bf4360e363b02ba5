// The keys of the box file, described once.
#pragma once

#include "firmware/base/yaml.h"
#include "firmware/config/box_config.h"

namespace adit::config {

/// What may be said of a key.
struct KeyNote {
  const char* unit = "";
  const char* meaning = "";
};

/// Shows every key of `c` to `v`. A visitor has Enter/Leave for maps and, for values: Text, Required, Texts,
/// Choice, Flag, Whole, Number, Numbers.
template <class Visitor>
void DescribeCameras(CamerasConfig& c, Visitor& v) {
  v.Enter("cameras");
  v.Choice("driver", c.driver, {"aravis", "recording"},
           {"", "GigE Vision cameras, or a recording played back"});
  v.Enter("left");
  v.Text("device", c.left.device, {"", "IPv4 address or device id of the left camera"});
  v.Leave();
  v.Enter("right");
  v.Text("device", c.right.device, {"", "IPv4 address or device id of the right camera"});
  v.Leave();
  v.Text("recording", c.recording, {"", "folder to play back (driver recording)"});
  v.Number("rate_hz", c.rate_hz, {1, 1000}, {"Hz", "rate of the common trigger"});
  v.Number("exposure_us", c.exposure_us, {1, 1e6}, {"us", "exposure time"});
  v.Number("gain_db", c.gain_db, {0, 48}, {"dB", "analogue gain, where the camera has one"});
  v.Whole("bits", c.bits, {8, 12}, {"", "8, 10 or 12: Mono8, Mono10, Mono12 (unpacked)"});
  v.Whole("packet_size", c.packet_size, {576, 16384},
          {"byte", "GVSP packet; the network must carry it whole"});
  v.Choice("socket", c.socket, {"packet", "udp"}, {"", "packet needs CAP_NET_RAW and spares the processor"});
  v.Text("trigger_source", c.trigger_source, {"", "the camera's trigger input"});
  v.Flag("ptp", c.ptp, {"", "the cameras follow the box clock by PTP"});
  v.Whole("buffers", c.buffers, {4, 64}, {"", "frames in each camera's pool"});
  v.Leave();
}

template <class Visitor>
void DescribePublish(PublishConfig& p, Visitor& v) {
  v.Enter("publish");
  v.Texts("targets", p.targets,
          {"", "targets and bodies to publish, in the order of their nodes; empty: all"});
  v.Numbers("site_origin_m", p.site_origin_m, 3, {-1e8, 1e8},
            {"m", "E0, N0, H0: whole metres; positions go out as differences from it"});
  v.Number("sigma_limit_mm", p.sigma_limit_mm, {0.1, 1000}, {"mm", "above it a position is DEGRADED"});
  v.Number("age_limit_ms", p.age_limit_ms, {10, 250}, {"ms", "an older position is INVALID"});
  v.Enter("can");
  v.Choice("driver", p.can.driver, {"none", "socketcan", "candump"},
           {"", "candump writes a log file instead of a bus"});
  v.Text("interface", p.can.interface_name, {"", "network interface of the bus"});
  v.Text("log", p.can.log, {"", "file of the driver candump"});
  v.Whole("node", p.can.node, {1, 126}, {"", "CANopen node of the first target; the next takes two more"});
  v.Number("cycle_ms", p.can.cycle_ms, {20, 1000}, {"ms", "time from epoch to epoch"});
  v.Leave();
  v.Enter("modbus");
  v.Flag("enabled", p.modbus.enabled, {"", "serve Modbus TCP"});
  v.Text("bind", p.modbus.bind, {"", "address to listen on"});
  v.Whole("port", p.modbus.port, {1, 65535}, {"", "TCP port"});
  v.Whole("unit", p.modbus.unit, {1, 247}, {"", "own unit id"});
  v.Leave();
  v.Enter("dtrack");
  v.Text(
      "address", p.dtrack.address,
      {"", "IPv4 address that gets each pair as an ART DTrack datagram, for looking on only; empty: none"});
  v.Whole("port", p.dtrack.port, {1, 65535}, {"", "its UDP port"});
  v.Leave();
  v.Leave();
}

template <class Visitor>
void DescribeBox(BoxConfig& c, Visitor& v) {
  v.Text("serial", c.serial, {"", "of this box, as its identification registers show it"});
  v.Flag("simulation", c.simulation,
         {"", "everything is published as SIMULATED and must never move a machine"});
  v.Required("rig", c.rig, {"", "the rig's calibration (Kalibr camchain)"});
  v.RequiredTexts("models", c.models, {"", "the trained targets"});
  v.Texts("bodies", c.bodies,
          {"", "machines of two bars or more, published with heading, pitch and roll after the models"});
  v.Text("georeference", c.georeference,
         {"", "the rig in the site grid (adit georef); empty: positions are in the rig frame"});
  DescribeCameras(c.cameras, v);
  v.Enter("detector");
  v.Number("area_min_px", c.detector.area_min_px, {1, 1e5}, {"px", "smallest bright area of an LED"});
  v.Number("area_max_px", c.detector.area_max_px, {1, 1e6}, {"px", "largest bright area of an LED"});
  v.Number("elongation_max", c.detector.elongation_max, {1, 20}, {"", "longest to shortest axis of an LED"});
  v.Number("read_noise_dn", c.detector.read_noise_dn, {0.01, 50}, {"DN", "of a dark pixel, at 8 bit"});
  v.Number("electrons_per_dn", c.detector.electrons_per_dn, {0.1, 1e5},
           {"e-/DN", "conversion gain, at 8 bit"});
  v.Leave();
  v.Enter("track");
  v.Flag("filter", c.track.filter,
         {"", "smooth positions by a constant velocity filter; short losses are bridged and DEGRADED"});
  v.Leave();
  DescribePublish(c.publish, v);
  v.Enter("watch");
  v.Flag("enabled", c.watch.enabled,
         {"",
          "look for a turn of the right camera since the calibration, in the traffic itself; DEGRADED then"});
  v.Whole("learn_s", c.watch.learn_s, {60, 3600},
          {"s", "tracking of each target after the start that later traffic is compared with"});
  v.Number("shift_mm", c.watch.shift_mm, {0.001, 10},
           {"mm", "1 sigma by which the cameras may move against each other with no harm"});
  v.Numbers("lights_m", c.watch.lights_m, 0, {-1000, 1000},
            {"m", "fixed LEDs, three or more: x, y, z in the rig frame of one after the other; empty: none"});
  v.Leave();
  v.Enter("realtime");
  v.Whole("priority", c.realtime.priority, {0, 99}, {"", "SCHED_FIFO priority; 0: ordinary scheduling"});
  v.Flag("lock_memory", c.realtime.lock_memory, {"", "keep the program in memory"});
  v.Numbers("cpus", c.realtime.cpus, 0, {0, 1023}, {"", "processors for the hot threads; empty: any"});
  v.Leave();
  v.Text("track_log", c.track_log, {"", "file that gets one row per pair and target; empty: none"});
  v.Text("health_report", c.health_report,
         {"", "file replaced every second, counters and latencies for adit latency; best in memory (/run)"});
}

}  // namespace adit::config
