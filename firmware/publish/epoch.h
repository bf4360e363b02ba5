// One epoch: all that the box tells a machine about one target at one moment. The input of every encoder.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/base/time.h"
#include "firmware/georef/geo_fix.h"

namespace adit::publish {

enum class Validity : std::uint8_t {
  kInvalid = 0,  ///< no position; every value is "not available"
  kValid = 1,    ///< measured, fresh, within its limits
  kDegraded =
      2,  ///< extrapolated or rebuilt, sigma above its limit, calibration in doubt, or the box is in service
  kSimulated = 3,  ///< must never move a machine
};

enum class BoxState : std::uint8_t {
  kInit = 0,        ///< no pair of images yet
  kSearch = 1,      ///< the target was never seen
  kTrack = 2,       ///< a valid position
  kDegraded = 3,    ///< a degraded position
  kLost = 4,        ///< the target was seen before and is not now
  kService = 5,     ///< somebody works on the box
  kFault = 6,       ///< a fault that rules positions out (kFaultsThatStop)
  kSimulation = 7,  ///< the images are not of this world
};

/// Where the box clock has its time from.
enum class ClockSource : std::uint8_t { kNone = 0, kHoldover = 1, kNtp = 2, kPtp = 3 };

inline constexpr std::uint16_t kFaultCameraA = 1U << 0;
inline constexpr std::uint16_t kFaultCameraB = 1U << 1;
inline constexpr std::uint16_t kFaultCameraSync = 1U << 2;
inline constexpr std::uint16_t kFaultRadio = 1U << 3;
inline constexpr std::uint16_t kFaultFilterWheel = 1U << 4;
inline constexpr std::uint16_t kFaultGeoreference = 1U << 5;
inline constexpr std::uint16_t kFaultResidual = 1U << 6;
inline constexpr std::uint16_t kFaultTimeSync = 1U << 7;
inline constexpr std::uint16_t kFaultCanStalled = 1U << 8;
inline constexpr std::uint16_t kFaultBusOff = 1U << 9;
inline constexpr std::uint16_t kFaultTemperature = 1U << 10;
inline constexpr std::uint16_t kFaultStorage = 1U << 11;
inline constexpr std::uint16_t kFaultPlcHeartbeat = 1U << 12;
inline constexpr std::uint16_t kFaultConfiguration = 1U << 13;
inline constexpr std::uint16_t kFaultUpdate = 1U << 14;
inline constexpr std::uint16_t kFaultInternal = 1U << 15;

/// With one of these no position can be right, however fresh it looks: INVALID at once, before its age says
/// so.
inline constexpr std::uint16_t kFaultsThatStop = kFaultCameraA | kFaultCameraB | kFaultInternal;

/// With one of these a position may be off by more than its sigma says: DEGRADED.
inline constexpr std::uint16_t kFaultsThatDegrade = kFaultResidual;

/// The box at the moment of publishing, apart from any target.
struct BoxCondition {
  std::uint16_t epoch = 0;      ///< +1 each epoch; its low byte is the counter on CAN
  std::uint8_t alive = 0;       ///< +1 each cycle, with or without images
  std::uint16_t heartbeat = 0;  ///< +1 every 100 ms, always
  bool initialised = false;     ///< a pair of images went through since the start
  bool simulation = false;
  bool service = false;
  bool georeferenced = false;
  std::uint16_t faults = 0;  ///< what the box knows; MakeEpoch adds kFaultGeoreference
  std::uint8_t targets_seen = 0;
  std::uint8_t targets_used = 0;
  ClockSource clock = ClockSource::kNone;
};

/// The largest difference from the origin that an i32 of 0.1 mm carries; the smallest i32 means "not
/// available".
inline constexpr double kOffsetMaxM = 214748.3647;

/// Whether a difference from the site origin can be told to a machine.
bool FitsTheWire(const Eigen::Vector3d& offset_s_m);

/// What a position must keep to.
struct EpochRules {
  double sigma_limit_m = 0.020;                          ///< above: DEGRADED
  base::DurationNs age_limit_ns = 100 * base::kNsPerMs;  ///< above: INVALID
  std::array<std::int32_t, 3> origin_s_m{};              ///< E0, N0, H0; whole metres
};

/// Trivially copyable, no heap. Values that are absent are "not available" on the wire.
struct Epoch {
  std::uint16_t number = 0;
  Validity validity = Validity::kInvalid;
  BoxState state = BoxState::kInit;
  std::uint16_t faults = 0;
  std::uint8_t alive = 0;
  std::uint8_t targets_seen = 0;
  std::uint8_t targets_used = 0;
  std::uint16_t heartbeat = 0;
  ClockSource clock = ClockSource::kNone;
  bool georeferenced = false;
  bool sigma_ok = false;                        ///< there is a position, and its sigmas are within the limit
  base::TimeNs mid_exposure_ns = base::kNever;  ///< of the last pair, also when the target is not in it
  base::DurationNs age_limit_ns = 0;
  std::array<std::int32_t, 3> origin_s_m{};
  std::optional<std::array<double, 3>> position_s_m;  ///< E, N, H in full
  std::optional<double> sigma_horizontal_m;           ///< sqrt(sE^2 + sN^2), Helmert's point error
  std::optional<double> sigma_vertical_m;
  std::optional<double> heading_rad, pitch_rad, roll_rad;  ///< of a body on the site grid (georef::Attitude)
};

/// Judges a fix. In order: a fault of kFaultsThatStop, no fix, a lost or old one (older than the limit, or
/// dated more than kClockSlackNs into the future), a number that is not finite, or a difference from the
/// origin that does not fit the wire is INVALID and has no values; then simulation is SIMULATED; predicted,
/// recovered, a sigma above the limit, a fault of kFaultsThatDegrade or a box in service is DEGRADED; the
/// rest is VALID. Without a georeference the site frame is the rig frame: fault bit 5 says so, and an origin
/// other than zero makes it INVALID, for it would shift coordinates that it does not belong to. `fix` may be
/// null. Any thread.
Epoch MakeEpoch(const georef::GeoFix* fix, const BoxCondition& box, const EpochRules& rules,
                base::TimeNs now_ns);

/// `epoch` as it may be told at `now_ns`: what has become too old since is INVALID and without values.
Epoch AsOf(const Epoch& epoch, base::TimeNs now_ns);

/// From mid-exposure to `now_ns`; nothing if there was no exposure or it lies in the future.
std::optional<base::DurationNs> AgeAt(const Epoch& epoch, base::TimeNs now_ns);

/// An exposure may be dated this much after "now" by the rounding of two clocks, and counts as age 0.
inline constexpr base::DurationNs kClockSlackNs = 2 * base::kNsPerMs;

}  // namespace adit::publish
