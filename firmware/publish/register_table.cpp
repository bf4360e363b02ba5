// The part of the signal table that only the register map has: target structs, labels, discrete inputs,
// areas.
#include <algorithm>
#include <cmath>

#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

using Target = TargetRecord;

std::int64_t Clamped(double value, std::int64_t low, std::int64_t high) {
  return static_cast<std::int64_t>(
      std::clamp(std::round(value), static_cast<double>(low), static_cast<double>(high)));
}

std::int64_t Coordinate(const Epoch& epoch, std::size_t axis) {
  constexpr double kStepsPerMetre = 1e4;
  if (!epoch.position_s_m) return kNoI32;
  return Clamped(((*epoch.position_s_m)[axis] - epoch.origin_s_m[axis]) * kStepsPerMetre, INT32_MIN + 1,
                 INT32_MAX);
}

// One number for the quality of a point: sqrt(sE^2 + sN^2 + sH^2).
std::int64_t PointSigma(const Epoch& epoch) {
  constexpr double kStepsPerMetre = 1e4;
  if (!epoch.sigma_horizontal_m || !epoch.sigma_vertical_m) return kNoU16;
  return Clamped(std::hypot(*epoch.sigma_horizontal_m, *epoch.sigma_vertical_m) * kStepsPerMetre, 0,
                 UINT16_MAX - 1);
}

std::int64_t Residual(const Target& t) {
  constexpr double kStepsPerPixel = 100;
  if (!t.epoch.position_s_m || !std::isfinite(t.residual_px)) return kNoU16;
  return Clamped(t.residual_px * kStepsPerPixel, 0, UINT16_MAX - 1);
}

std::int64_t AgeMs(const Target& t, base::TimeNs now_ns) {
  const std::optional<base::DurationNs> age_ns = AgeAt(t.epoch, now_ns);
  return age_ns ? std::min<std::int64_t>(*age_ns / base::kNsPerMs, UINT16_MAX - 1) : kNoU16;
}

std::int64_t SecondsSinceSeen(const Target& t, base::TimeNs now_ns) {
  if (t.last_seen_ns == base::kNever || now_ns == base::kNever) return kNoU16;
  return std::clamp<std::int64_t>((now_ns - t.last_seen_ns) / base::kNsPerS, 0, UINT16_MAX - 1);
}

using enum WireType;
using base::TimeNs;

bool HasFault(const BoxRecord& r, std::uint16_t bits) { return (r.epoch.faults & bits) != 0; }

// clang-format off
constexpr TargetRow kTargetRows[] = {
    {0, "Id", "", 1, kU16, kAlways, "place in the model list from 1; 0 no such target", [](const Target& t, TimeNs) { return std::int64_t{t.id}; }},
    {1, "State", "", 1, kU16, kAlways, "1 tracked 2 recovered 3 predicted 4 lost", [](const Target& t, TimeNs) { return std::int64_t{t.status}; }},
    {2, "Validity", "", 1, kU16, kAlways, "as register 102", [](const Target& t, TimeNs) { return static_cast<std::int64_t>(t.epoch.validity); }},
    {3, "Age", "ms", 1, kU16, kNoU16, "from mid-exposure to the answer", AgeMs},
    {4, "E", "m", 1e-4, kI32, kNoI32, "easting - E0", [](const Target& t, TimeNs) { return Coordinate(t.epoch, 0); }},
    {6, "N", "m", 1e-4, kI32, kNoI32, "northing - N0", [](const Target& t, TimeNs) { return Coordinate(t.epoch, 1); }},
    {8, "H", "m", 1e-4, kI32, kNoI32, "height - H0", [](const Target& t, TimeNs) { return Coordinate(t.epoch, 2); }},
    {10, "Sigma", "m", 1e-4, kU16, kNoU16, "sqrt(sE^2 + sN^2 + sH^2)", [](const Target& t, TimeNs) { return PointSigma(t.epoch); }},
    {11, "Residual", "px", 0.01, kU16, kNoU16, "rms of the reprojection", [](const Target& t, TimeNs) { return Residual(t); }},
    {12, "LastSeen", "s", 1, kU16, kNoU16, "since the last position", SecondsSinceSeen},
};

constexpr LabelRow kLabelRows[] = {
    {400, "Vendor", &BoxIdentity::vendor},
    {416, "Product", &BoxIdentity::product},
    {432, "SerialText", &BoxIdentity::serial},
    {448, "VersionText", &BoxIdentity::version},
};

constexpr BitRow kBitRows[] = {
    {"Alive", "the publisher runs: it spoke within the last second", [](const BoxRecord& r) { return r.publisher_alive; }},
    {"Valid", "validity is VALID", [](const BoxRecord& r) { return r.epoch.validity == Validity::kValid; }},
    {"Degraded", "validity is DEGRADED", [](const BoxRecord& r) { return r.epoch.validity == Validity::kDegraded; }},
    {"Simulated", "validity is SIMULATED, or the box is in SIMULATION", [](const BoxRecord& r) { return r.epoch.validity == Validity::kSimulated || r.epoch.state == BoxState::kSimulation; }},
    {"Fault", "some fault bit is set", [](const BoxRecord& r) { return r.epoch.faults != 0; }},
    {"CameraA", "camera A is well", [](const BoxRecord& r) { return !HasFault(r, kFaultCameraA); }},
    {"CameraB", "camera B is well", [](const BoxRecord& r) { return !HasFault(r, kFaultCameraB); }},
    {"Radio", "radio and LEDs are well", [](const BoxRecord& r) { return !HasFault(r, kFaultRadio); }},
    {"CanOk", "CAN transmits", [](const BoxRecord& r) { return !HasFault(r, kFaultCanStalled); }},
    {"TimeSync", "the clock follows NTP or PTP", [](const BoxRecord& r) { return r.epoch.clock == ClockSource::kNtp || r.epoch.clock == ClockSource::kPtp; }},
    {"PlcHeartbeatOk", "the heartbeat of the PLC is not missed", [](const BoxRecord& r) { return !HasFault(r, kFaultPlcHeartbeat); }},
    {"UpdatePending", "an update waits for the next start", [](const BoxRecord& r) { return HasFault(r, kFaultUpdate); }},
    {"GeorefOk", "coordinates are in the site grid", [](const BoxRecord& r) { return !HasFault(r, kFaultGeoreference); }},
    {"AlignmentOk", "an alignment is loaded", [](const BoxRecord& r) { return r.identity.alignment_hash != 0; }},
    {"SigmaOk", "there is a position and its sigmas are within the limit", [](const BoxRecord& r) { return r.epoch.sigma_ok; }},
    {"Service", "the box is in SERVICE", [](const BoxRecord& r) { return r.epoch.state == BoxState::kService; }},
};
static_assert(std::size(kBitRows) == kDiscreteInputs);

constexpr const char* kFaultNames[] = {
    "camera A", "camera B", "camera sync", "radio/LED", "filter wheel", "georeference missing or expired",
    "residual limit", "time sync", "CAN transmit stalled", "bus-off since boot", "over-temperature", "storage",
    "PLC heartbeat lost", "configuration changed", "update pending", "internal",
};

constexpr RegisterArea kAreas[] = {
    {0, 9, "identification and constants that show a wrong word order"},
    {kLiveFirst, kLiveLength, "live block: read it in one request, it is one epoch"},
    {200, 12, "full coordinates"},
    {220, 12, "origin and versions"},
    {300, 60, "diagnostics"},
    {400, 64, "identification, ASCII"},
    {kTargetsFirst, kRegisterEnd - kTargetsFirst, "targets"},
};
// clang-format on

}  // namespace

std::span<const TargetRow> TargetRows() { return kTargetRows; }
std::span<const LabelRow> LabelRows() { return kLabelRows; }
std::span<const BitRow> BitRows() { return kBitRows; }
std::span<const char* const> FaultNames() { return kFaultNames; }
std::span<const RegisterArea> RegisterAreas() { return kAreas; }

}  // namespace adit::publish
