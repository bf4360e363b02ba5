#include "firmware/publish/signal_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace adit::publish {
namespace {

constexpr double kStepDeg = 1e-4;

using Record = BoxRecord;

// Rounds to whole steps, kept inside [low, high].
std::int64_t Steps(double value, double step, std::int64_t low, std::int64_t high) {
  const double steps = std::round(value / step);
  return static_cast<std::int64_t>(std::clamp(steps, static_cast<double>(low), static_cast<double>(high)));
}

// A coordinate as difference from the origin. MakeEpoch has seen to it that it fits.
std::int64_t Offset(const Epoch& epoch, std::size_t axis) {
  if (!epoch.position_s_m) return kNoI32;
  return Steps((*epoch.position_s_m)[axis] - epoch.origin_s_m[axis], kStepM, INT32_MIN + 1, INT32_MAX);
}

std::int64_t FullMetres(const Epoch& epoch, std::size_t axis) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return std::bit_cast<std::int64_t>(epoch.position_s_m ? (*epoch.position_s_m)[axis] : kNone);
}

std::int64_t Angle(const std::optional<double>& angle_rad) {
  if (!angle_rad) return kNoI32;
  return Steps(*angle_rad * 180.0 / std::numbers::pi, kStepDeg, INT32_MIN + 1, INT32_MAX);
}

// 65534 also stands for everything above it: 65535 means "not available".
std::int64_t Sigma(const std::optional<double>& sigma_m) {
  return sigma_m ? Steps(*sigma_m, kStepM, 0, UINT16_MAX - 1) : kNoU16;
}

std::int64_t AgeMs(const Epoch& epoch, base::TimeNs now_ns) {
  const std::optional<base::DurationNs> age_ns = AgeAt(epoch, now_ns);
  return age_ns ? std::min<std::int64_t>(*age_ns / base::kNsPerMs, UINT16_MAX - 1) : kNoU16;
}

// UTC of the exposure; the box clock counts from the Unix epoch.
std::int64_t UtcPart(const Epoch& epoch, base::DurationNs unit_ns, std::int64_t modulus) {
  return epoch.mid_exposure_ns <= 0 ? 0 : epoch.mid_exposure_ns / unit_ns % modulus;
}

std::int64_t Temperature(const Record& r) {
  constexpr double kStepCelsius = 0.1;
  const std::optional<double>& value = r.health.temperature_celsius;
  return value ? Steps(*value, kStepCelsius, INT16_MIN + 1, INT16_MAX) : kNoI16;
}

std::int64_t Rate(const CameraFigures& camera) { return Steps(camera.rate_hz, 0.01, 0, UINT16_MAX); }

std::int64_t RadioLoss(const Record& r) {
  return r.health.radio_loss ? Steps(*r.health.radio_loss, 1e-4, 0, 10'000) : kNoU16;
}

std::int64_t VersionWord(const Record& r) {
  return r.identity.version_numbers[0] * 256 + r.identity.version_numbers[1];
}

// What has no source in this version.
std::int64_t AbsentI32(const Record&) { return kNoI32; }
std::int64_t AbsentI16(const Record&) { return kNoI16; }

constexpr CanPlace kNotOnCan{};
constexpr std::nullopt_t kNotInMap = std::nullopt;
using enum WireType;

// clang-format off
constexpr SignalRow kSignals[] = {
    // name, unit, scale, type, not available, CAN {slot, bit, bits}, register, meaning, raw
    {"Magic", "", 1, kU32, kAlways, kNotOnCan, 0, "`ADIT`", [](const Record&) { return std::int64_t{0x41444954}; }},
    {"MapVersion", "", 1, kU16, kAlways, kNotOnCan, 2, "major, minor", [](const Record&) { return std::int64_t{kMapVersion}; }},
    {"LiveLength", "", 1, kU16, kAlways, kNotOnCan, 3, "registers of the live block", [](const Record&) { return std::int64_t{kLiveLength}; }},
    {"TestU32", "", 1, kU32, kAlways, kNotOnCan, 4, "always 0x12345678", [](const Record&) { return std::int64_t{0x12345678}; }},
    {"TestF32", "", 1, kF32, kAlways, kNotOnCan, 6, "always 123.456", [](const Record&) { return std::int64_t{std::bit_cast<std::uint32_t>(123.456F)}; }},
    {"TestI16", "", 1, kI16, kAlways, kNotOnCan, 8, "always -2", [](const Record&) { return std::int64_t{-2}; }},

    {"Epoch", "", 1, kU16, kAlways, kNotOnCan, 100, "number of the epoch; low byte = counter on CAN", [](const Record& r) { return std::int64_t{r.epoch.number}; }},
    {"State", "", 1, kU16, kAlways, {3, 0, 4}, 101, "0 INIT 1 SEARCH 2 TRACK 3 DEGRADED 4 LOST 5 SERVICE 6 FAULT 7 SIMULATION", [](const Record& r) { return static_cast<std::int64_t>(r.epoch.state); }},
    {"Validity", "", 1, kU16, kAlways, kNotOnCan, 102, "0 INVALID 1 VALID 2 DEGRADED 3 SIMULATED", [](const Record& r) { return static_cast<std::int64_t>(r.epoch.validity); }},
    {"Age", "ms", 1, kU16, kNoU16, kNotOnCan, 103, "from mid-exposure to the answer; 65535 never", [](const Record& r) { return AgeMs(r.epoch, r.now_ns); }},
    {"POS_E", "m", kStepM, kI32, kNoI32, {0, 0, 32}, 104, "easting - E0", [](const Record& r) { return Offset(r.epoch, 0); }},
    {"POS_N", "m", kStepM, kI32, kNoI32, {1, 0, 32}, 106, "northing - N0", [](const Record& r) { return Offset(r.epoch, 1); }},
    {"POS_H", "m", kStepM, kI32, kNoI32, {2, 0, 32}, 108, "height - H0", [](const Record& r) { return Offset(r.epoch, 2); }},
    {"HEADING", "deg", kStepDeg, kI32, kNoI32, {4, 0, 32}, 110, "of a body on the site grid, clockwise from grid north; else not available", [](const Record& r) { return Angle(r.epoch.heading_rad); }},
    {"PITCH", "deg", kStepDeg, kI32, kNoI32, {5, 0, 32}, 112, "of its x axis, up positive; as HEADING", [](const Record& r) { return Angle(r.epoch.pitch_rad); }},
    {"ROLL", "deg", kStepDeg, kI32, kNoI32, {6, 0, 32}, 114, "right side down positive; as HEADING", [](const Record& r) { return Angle(r.epoch.roll_rad); }},
    {"SigmaH", "m", kStepM, kU16, kNoU16, {7, 0, 16}, 116, "sqrt(sE^2 + sN^2); 65534 or more reads 65534", [](const Record& r) { return Sigma(r.epoch.sigma_horizontal_m); }},
    {"SigmaV", "m", kStepM, kU16, kNoU16, {7, 16, 16}, 117, "sH; 65534 or more reads 65534", [](const Record& r) { return Sigma(r.epoch.sigma_vertical_m); }},
    {"TargetsSeen", "", 1, kU16, kAlways, kNotOnCan, 118, "targets with a position in the last pair", [](const Record& r) { return std::int64_t{r.epoch.targets_seen}; }},
    {"TargetsUsed", "", 1, kU16, kAlways, {3, 4, 4}, 119, "of these in the published position; 15 or more reads 15 on CAN", [](const Record& r) { return std::int64_t{r.epoch.targets_used}; }},
    {"Faults", "", 1, kU32, kAlways, {3, 8, 16}, 120, "fault bits", [](const Record& r) { return std::int64_t{r.epoch.faults}; }},
    {"AliveBox", "", 1, kU16, kAlways, {3, 24, 8}, kNotInMap, "+1 each cycle, also without images", [](const Record& r) { return std::int64_t{r.epoch.alive}; }},
    {"CHAINAGE", "m", kStepM, kI32, kNoI32, {9, 0, 32}, 122, "with an alignment loaded", AbsentI32},
    {"LAT_FRONT", "m", kStepM, kI32, kNoI32, {10, 0, 32}, 124, "+ right of the axis", AbsentI32},
    {"VERT_FRONT", "m", kStepM, kI32, kNoI32, {11, 0, 32}, 126, "+ above the axis", AbsentI32},
    {"TendencyH", "m/m", kStepM, kI16, kNoI16, {12, 0, 16}, 128, "horizontal; 0.1 mm/m", AbsentI16},
    {"TendencyV", "m/m", kStepM, kI16, kNoI16, {12, 16, 16}, 129, "vertical; 0.1 mm/m", AbsentI16},
    {"LAT_REAR", "m", kStepM, kI32, kNoI32, {13, 0, 32}, 130, "+ right of the axis", AbsentI32},
    {"VERT_REAR", "m", kStepM, kI32, kNoI32, {14, 0, 32}, 132, "+ above the axis", AbsentI32},
    {"UtcSeconds", "s", 1, kU32, kAlways, kNotOnCan, 134, "mid-exposure since 1970; 0 never", [](const Record& r) { return UtcPart(r.epoch, base::kNsPerS, std::int64_t{1} << 32); }},
    {"UtcMillis", "ms", 1, kU16, kAlways, kNotOnCan, 136, "milliseconds of it", [](const Record& r) { return UtcPart(r.epoch, base::kNsPerMs, 1000); }},
    {"Clock", "", 1, kU16, kAlways, kNotOnCan, 137, "0 none 1 holdover 2 NTP 3 PTP", [](const Record& r) { return static_cast<std::int64_t>(r.epoch.clock); }},
    {"Heartbeat", "", 1, kU16, kAlways, kNotOnCan, 138, "+1 every 100 ms, always", [](const Record& r) { return std::int64_t{r.epoch.heartbeat}; }},
    {"ConfigCrcLow", "", 1, kU16, kAlways, kNotOnCan, 139, "low word of ConfigCrc", [](const Record& r) { return std::int64_t{r.identity.config_crc32 & 0xFFFFU}; }},
    {"EpochAgain", "", 1, kU16, kAlways, kNotOnCan, 140, "register 100 once more", [](const Record& r) { return std::int64_t{r.epoch.number}; }},

    {"Easting", "m", 1, kF64, kAlways, kNotOnCan, 200, "in full; NaN not available", [](const Record& r) { return FullMetres(r.epoch, 0); }},
    {"Northing", "m", 1, kF64, kAlways, kNotOnCan, 204, "in full; NaN not available", [](const Record& r) { return FullMetres(r.epoch, 1); }},
    {"Height", "m", 1, kF64, kAlways, kNotOnCan, 208, "in full; NaN not available", [](const Record& r) { return FullMetres(r.epoch, 2); }},
    {"E0", "m", 1, kI32, kAlways, kNotOnCan, 220, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[0]}; }},
    {"N0", "m", 1, kI32, kAlways, kNotOnCan, 222, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[1]}; }},
    {"H0", "m", 1, kI32, kAlways, kNotOnCan, 224, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[2]}; }},
    {"EPSG", "", 1, kU32, kAlways, kNotOnCan, 226, "code of the site grid; 0 unknown", [](const Record& r) { return std::int64_t{r.identity.epsg}; }},
    {"AlignmentHash", "", 1, kU32, kAlways, kNotOnCan, 228, "0 none loaded", [](const Record& r) { return std::int64_t{r.identity.alignment_hash}; }},
    {"ConfigCrc", "", 1, kU32, kAlways, kNotOnCan, 230, "CRC-32 of the configuration file", [](const Record& r) { return std::int64_t{r.identity.config_crc32}; }},

    {"Uptime", "s", 1, kU32, kAlways, kNotOnCan, 300, "", [](const Record& r) { return std::int64_t{r.health.uptime_s}; }},
    {"Version", "", 1, kU16, kAlways, kNotOnCan, 302, "high byte major, low byte minor", VersionWord},
    {"VersionPatch", "", 1, kU16, kAlways, kNotOnCan, 303, "", [](const Record& r) { return std::int64_t{r.identity.version_numbers[2]}; }},
    {"Temperature", "degC", 0.1, kI16, kNoI16, kNotOnCan, 304, "inside the box", Temperature},
    {"CameraARate", "Hz", 0.01, kU16, kAlways, kNotOnCan, 306, "frames a second", [](const Record& r) { return Rate(r.health.cameras[0]); }},
    {"CameraBRate", "Hz", 0.01, kU16, kAlways, kNotOnCan, 307, "frames a second", [](const Record& r) { return Rate(r.health.cameras[1]); }},
    {"CameraALost", "", 1, kU32, kAlways, kNotOnCan, 308, "frames, since start", [](const Record& r) { return std::int64_t{r.health.cameras[0].lost}; }},
    {"CameraBLost", "", 1, kU32, kAlways, kNotOnCan, 310, "frames, since start", [](const Record& r) { return std::int64_t{r.health.cameras[1].lost}; }},
    {"RadioLoss", "", 1e-4, kU16, kNoU16, kNotOnCan, 312, "share of packets", RadioLoss},
    {"FilterPosition", "", 1, kU16, kNoU16, kNotOnCan, 313, "of the filter wheel", [](const Record& r) { return std::int64_t{r.health.filter_position.value_or(static_cast<std::uint16_t>(kNoU16))}; }},
    {"CanSent", "", 1, kU32, kAlways, kNotOnCan, 314, "frames handed to the bus", [](const Record& r) { return std::int64_t{r.health.can_sent_frames}; }},
    {"CanErrors", "", 1, kU32, kAlways, kNotOnCan, 316, "error frames", [](const Record& r) { return std::int64_t{r.health.can_errors}; }},
    {"CanBusOff", "", 1, kU32, kAlways, kNotOnCan, 318, "times bus-off", [](const Record& r) { return std::int64_t{r.health.can_bus_off}; }},
    {"CanDropped", "", 1, kU32, kAlways, kNotOnCan, 320, "epochs not sent or not confirmed", [](const Record& r) { return std::int64_t{r.health.can_dropped_epochs}; }},
    {"ModbusClients", "", 1, kU16, kAlways, kNotOnCan, 322, "connected now", [](const Record& r) { return std::int64_t{r.health.modbus_clients}; }},
    {"ModbusLimit", "", 1, kU16, kAlways, kNotOnCan, 323, "connections at most", [](const Record& r) { return std::int64_t{r.health.modbus_clients_max}; }},
};

constexpr CanSlot kCanSlots[] = {
    {0, "POS_E", 0x180, 0}, {1, "POS_N", 0x280, 0}, {2, "POS_H", 0x380, 0}, {3, "STATUS", 0x480, 0},
    {4, "HEADING", 0x200, 0}, {5, "PITCH", 0x300, 0}, {6, "ROLL", 0x400, 0}, {7, "QUALITY", 0x500, 0},
    {8, "INFO", 0x680, 0},
    {9, "CHAINAGE", 0x180, 1}, {10, "LAT_FRONT", 0x280, 1}, {11, "VERT_FRONT", 0x380, 1},
    {12, "TENDENCY", 0x480, 1}, {13, "LAT_REAR", 0x200, 1}, {14, "VERT_REAR", 0x300, 1},
};

constexpr InfoRow kInfoRows[] = {
    {"ProtocolVersion", "", kU32, "high byte major, low byte minor: 0x0100", [](const Record&) { return std::int64_t{0x0100}; }},
    {"Serial", "", kU32, "0 if the serial is not a number", [](const Record& r) { return std::int64_t{r.identity.serial_number}; }},
    {"Software", "", kU32, "major x 65536 + minor x 256 + patch", [](const Record& r) { return VersionWord(r) * 256 + r.identity.version_numbers[2]; }},
    {"ConfigCrc", "", kU32, "CRC-32 of the configuration file", [](const Record& r) { return std::int64_t{r.identity.config_crc32}; }},
    {"E0", "m", kI32, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[0]}; }},
    {"N0", "m", kI32, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[1]}; }},
    {"H0", "m", kI32, "origin", [](const Record& r) { return std::int64_t{r.epoch.origin_s_m[2]}; }},
    {"EPSG", "", kU32, "code of the site grid; 0 unknown", [](const Record& r) { return std::int64_t{r.identity.epsg}; }},
    {"Uptime", "s", kU32, "", [](const Record& r) { return std::int64_t{r.health.uptime_s}; }},
    {"UTC", "s", kU32, "of the box clock at hand-over, since 1970", [](const Record& r) { return r.now_ns < 0 ? 0 : r.now_ns / base::kNsPerS; }},
    {"Restarts", "", kU32, "of the box", [](const Record& r) { return std::int64_t{r.health.restarts}; }},
};
// clang-format on

}  // namespace

std::span<const SignalRow> Signals() { return kSignals; }
std::span<const CanSlot> CanSlots() { return kCanSlots; }
std::span<const InfoRow> InfoRows() { return kInfoRows; }

const CanSlot* FindCanSlot(std::uint8_t slot) {
  static_assert(kCanSlots[kStatusSlot].slot == kStatusSlot && kCanSlots[kInfoSlot].slot == kInfoSlot);
  // The table stands in the order of its slots.
  return slot < std::size(kCanSlots) ? &kCanSlots[slot] : nullptr;
}

}  // namespace adit::publish
